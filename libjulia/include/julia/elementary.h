// SPDX-License-Identifier: Apache-2.0
/// @file elementary.h
/// Elementary functions whose bits depend on IEEE 754 alone. The results of a C library may differ in the last bit from
/// one version or processor to the next. All values written to files, and all decisions, come from these functions or
/// from the kernels' own.
///
/// Special values are those of C (Annex F): log(0) is -inf, pow(x, 0) is 1, sin(inf) is not a number. Errors are given
/// in units in the last place (ulp) of the result; tests compare with 113 bits.
#pragma once

namespace julia::elementary {

/// Error within 0.51 ulp; exact if the result is representable as a double.
double log(double x);
double log2(double x);
double log10(double x);
/// ln(1 + x), within 2 ulp.
double log1p(double x);

/// Within 0.55 ulp.
double exp(double x);
double exp2(double x);
/// e^x - 1, within 2 ulp.
double expm1(double x);

/// Within 0.6 ulp. For whole y up to 1024 within 0.51 ulp, and therefore exact if the result is representable as a
/// double.
double pow(double x, double y);
/// Within 0.51 ulp.
double cbrt(double x);

/// Within 1.5 ulp.
double hypot(double x, double y);
double hypot(double x, double y, double z);

/// Within 3 ulp, for every finite x.
double sin(double x);
double cos(double x);
double tan(double x);  ///< within 5 ulp

/// Within 6 ulp.
double atan2(double y, double x);
double atan(double x);
double asin(double x);
double acos(double x);

/// Within 3 ulp.
double sinh(double x);
double cosh(double x);
double tanh(double x);

}  // namespace julia::elementary
