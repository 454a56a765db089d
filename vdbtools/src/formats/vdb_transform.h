// SPDX-License-Identifier: Apache-2.0
/// @file vdb_transform.h
/// The transform of a grid of a VDB, as it is stored in the file.
#pragma once

#include "formats/vdb_cursor.h"

namespace vdbtools {

/// Walks over a transform. OpenVDB stores values derived from a scale beside it, and trusts them.
/// @throw DataError  an unknown type, numbers that are not finite, a matrix that is not invertible or not affine, a
///                   scale of 0, or numbers that do not match the scale
void walkOverVdbTransform(VdbCursor& cursor);

}  // namespace vdbtools
