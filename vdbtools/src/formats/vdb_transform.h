// SPDX-License-Identifier: Apache-2.0
/// @file vdb_transform.h
/// The transform of a grid of a VDB, as it lies in the file.
#pragma once

#include "formats/vdb_cursor.h"

namespace vdbtools {

/// Walks over a transform. OpenVDB stores what it derives from a scale beside it, and believes it.
/// @throw DataError  a type that is not known, numbers that are not finite, a matrix that has no inverse or is not
/// affine,
///                   a scale of 0, or numbers that do not follow from the scale
void walkOverVdbTransform(VdbCursor& cursor);

}  // namespace vdbtools
