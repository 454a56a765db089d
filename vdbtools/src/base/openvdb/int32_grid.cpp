// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/grids.h"

template class openvdb::tree::Tree<openvdb::Int32Tree::RootNodeType>;
template class openvdb::Grid<openvdb::Int32Tree>;
