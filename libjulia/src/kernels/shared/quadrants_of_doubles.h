// SPDX-License-Identifier: Apache-2.0
// The body of quadrantsOfRadians(double x) as text of C++ and OpenCL C.
const double kTurns = 0.15915494309189533577, kQuadrants = 0.63661977236758134308, kTurnRounder = 0x1.8p52;
const double kTurnHigh = 0x1.921fb4p+2, kTurnMiddle = 0x1.4442dp-22, kTurnLow = 0x1.8469898cc5170p-46;
const double turns = (x * kTurns + kTurnRounder) - kTurnRounder;
const double rest = ((x - turns * kTurnHigh) - turns * kTurnMiddle) - turns * kTurnLow;
return rest * kQuadrants;
