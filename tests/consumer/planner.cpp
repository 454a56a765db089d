// SPDX-License-Identifier: Apache-2.0
#include <vdbtools/farm/plans.h>

int main() { return vdbtools::farm::parseFrames("1-3").size() != 3; }
