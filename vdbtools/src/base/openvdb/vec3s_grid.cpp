// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/grids.h"

template class openvdb::tree::Tree<openvdb::Vec3STree::RootNodeType>;
template class openvdb::Grid<openvdb::Vec3STree>;
