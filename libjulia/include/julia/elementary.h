// SPDX-License-Identifier: Apache-2.0
/// @file elementary.h
/// Elementary functions whose bits IEEE 754 alone decides, unlike those of a C library, which may differ in the last
/// bit from one version or processor to the next. Whatever is written to a file, and every decision, comes from these
/// or from the kernels' own.
///
/// Special values are those of C (Annex F): log(0) is -inf, pow(x, 0) is 1, sin(inf) is not a number. Errors are given
/// in units in the last place of the result; tests compare with 113 bits.
#pragma once

namespace julia::elementary {

/// Within 0.51 units, and exact where the result is a number of double.
double log(double x);
double log2(double x);
double log10(double x);
/// ln(1 + x), within 2 units.
double log1p(double x);

/// Within 0.55 units.
double exp(double x);
double exp2(double x);
/// e^x - 1, within 2 units.
double expm1(double x);

/// Within 0.6 units; within 0.51, and so exact where the result is a number of double, for whole y up to 1024.
double pow(double x, double y);
/// Within 0.51 units.
double cbrt(double x);

/// Within 1.5 units.
double hypot(double x, double y);
double hypot(double x, double y, double z);

/// Within 3 units, for every finite x.
double sin(double x);
double cos(double x);
double tan(double x);  ///< within 5

/// Within 6 units.
double atan2(double y, double x);
double atan(double x);
double asin(double x);
double acos(double x);

/// Within 3 units.
double sinh(double x);
double cosh(double x);
double tanh(double x);

}  // namespace julia::elementary
