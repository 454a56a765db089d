// SPDX-License-Identifier: Apache-2.0
// The body of quadrantsOfRadians(float x) as text of C++ and OpenCL C.
const double kQuadrants = 0.63661977236758134308, kTurnRounder = 0x1.8p52;
const double quadrants = (double)x * kQuadrants;
const double turns = (quadrants * 0.25 + kTurnRounder) - kTurnRounder;
return (float)(quadrants - 4 * turns);
