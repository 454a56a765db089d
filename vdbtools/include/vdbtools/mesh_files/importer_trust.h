// SPDX-License-Identifier: Apache-2.0
/// @file importer_trust.h
/// FBX, DAE, 3DS and X3D, which the library Assimp imports. Its importers have had many memory-safety defects: a file
/// can be made such that reading it does harm. They are therefore off until somebody says that the files can be
/// trusted. That is said of a process, and never by a recipe or a file.
#pragma once

namespace vdbtools {

/// Whether this build has Assimp.
bool canImport();

/// Whether the process imports files from now on. At first it does not.
void trustImporter(bool isTrusted);
bool isImporterTrusted();

}  // namespace vdbtools
