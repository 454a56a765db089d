// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/grids.h"

template class openvdb::tree::Tree<openvdb::MaskTree::RootNodeType>;
template class openvdb::Grid<openvdb::MaskTree>;
