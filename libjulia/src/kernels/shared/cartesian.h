// SPDX-License-Identifier: Apache-2.0
// Steps of maps in Cartesian form as text of C++ and OpenCL C (kernels/language.h). kernels/blocks.h includes it.

/// The square of a quaternion.
JULIA_SHARED void squareQuaternion(Real a, Real b, Real c, Real d, Real* sa, Real* sb, Real* sc, Real* sd) {
  *sa = a * a - (b * b + c * c + d * d);
  *sb = 2 * (a * b);
  *sc = 2 * (a * c);
  *sd = 2 * (a * d);
}

/// The pair A: f = r^2 (-sin 2phi, cos 2phi, 0), g = (-+ sin 2theta / cos 2phi, 0, cos 2theta), where @a sign 1 is the
/// upper sign. The product is the triplex square r^2 (cos 2phi cos 2theta, sin 2phi cos 2theta, +- sin 2theta), and for
/// the lower sign its mirror image in z. It is not defined where cos 2phi = 0: there the result is infinite, and the
/// orbit has escaped.
JULIA_SHARED void productOfA(int sign, Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
  const Real flat = magnitude(x) > magnitude(y) ? magnitude(x) : magnitude(y);
  const Real s = scaleToOne(flat), X = x * s, Y = y * s, across = X * X + Y * Y;
  const Real level = x * x + y * y;
  const Real cosine = level - z * z;  // r^2 cos 2theta
  const Real by = cosine / across, cross = X * X - Y * Y;
  const Real defined = across > 0 ? cross * by : cosine;
  *px = cross != 0 || !(across > 0) ? defined : JULIA_INFINITY;
  *py = across > 0 ? 2 * (X * Y) * by : JULIA_REAL(0);
  *pz = sign * 2 * (z * squareRoot(level));
}
JULIA_SHARED void secondOfA(int sign, Real x, Real y, Real z, Real* gx, Real* gy, Real* gz) {
  Real angles[4];
  doubleAngles(x, y, z, angles);
  *gx = angles[0] != 0 ? -sign * angles[3] / angles[0] : JULIA_INFINITY;
  *gy = JULIA_REAL(0);
  *gz = angles[2];
}

/// The pair B: f = (1, 1, 1), g = (cos x, cos y, cos z).
JULIA_SHARED void secondOfB(Real x, Real y, Real z, Real* gx, Real* gy, Real* gz) {
  *gx = cosineOfRadians(x);
  *gy = cosineOfRadians(y);
  *gz = cosineOfRadians(z);
}
JULIA_SHARED void productOfB(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
  Real gx, gy, gz;
  secondOfB(x, y, z, &gx, &gy, &gz);
  *px = gz - gy;
  *py = gx - gz;
  *pz = gy - gx;
}

/// The pair C: f = (x^2, y^2, z^2), g of B.
JULIA_SHARED void productOfC(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
  Real gx, gy, gz;
  secondOfB(x, y, z, &gx, &gy, &gz);
  const Real f1 = x * x, f2 = y * y, f3 = z * z;
  *px = f2 * gz - f3 * gy;
  *py = f3 * gx - f1 * gz;
  *pz = f1 * gy - f2 * gx;
}

/// The pair D: f of A, g = (0, 0, 1): r^2 (cos 2phi, sin 2phi, 0). For z = 0 it equals the complex square bit for bit.
JULIA_SHARED void productOfD(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
  const Real flat = magnitude(x) > magnitude(y) ? magnitude(x) : magnitude(y);
  const Real s = scaleToOne(flat), X = x * s, Y = y * s, across = X * X + Y * Y;
  const Real square = (x * x + y * y) + z * z, by = square / across;
  *px = across > 0 ? (X * X - Y * Y) * by : square;
  *py = across > 0 ? 2 * (X * Y) * by : JULIA_REAL(0);
  *pz = JULIA_REAL(0);
}

/// The pair E: f = (x^2 y, y^2, z^2), g = (1, cos z, 1).
JULIA_SHARED void productOfE(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
  const Real cosine = cosineOfRadians(z), f1 = x * x * y, f2 = y * y, f3 = z * z;
  *px = f2 - f3 * cosine;
  *py = f3 - f1;
  *pz = f1 * cosine - f2;
}

JULIA_SHARED void crossOf(Real fx, Real fy, Real fz, Real gx, Real gy, Real gz, Real* x, Real* y, Real* z) {
  *x = fy * gz - fz * gy;
  *y = fz * gx - fx * gz;
  *z = fx * gy - fy * gx;
}

/// The azimuth phi of a point as e^(i phi) = u + i v, and its distance from the z axis.
JULIA_SHARED void azimuthOf(Real x, Real y, Real* u, Real* v, Real* distance) {
  const Real flat = magnitude(x) > magnitude(y) ? magnitude(x) : magnitude(y);
  const Real s = scaleToOne(flat), X = x * s, Y = y * s, across = squareRoot(X * X + Y * Y);
  *u = across > 0 ? X / across : JULIA_REAL(1);
  *v = across > 0 ? Y / across : JULIA_REAL(0);
  *distance = flat > 0 ? across / s : JULIA_REAL(0);
}

/// r^p for r^2 = level^2 + z^2. @param halfPower  p / 2  @param atZero  0^p
JULIA_SHARED Real powerOfRadius(Real halfPower, Real atZero, Real level, Real z) {
  const Real square = level * level + z * z, least = JULIA_IEEE(kTiny), most = JULIA_IEEE(kMostExponent);
  const Real l = halfPower * logarithm(square > least ? square : least);
  const Real finite = exponential(l < most ? l : most);
  return square > 0 ? (l < most ? finite : JULIA_INFINITY) : atZero;
}

/// (a + i z) / |a + i z|, a >= 0; 1 for 0.
JULIA_SHARED void unitComplex(Real a, Real z, Real* real, Real* imaginary) {
  const Real largest = a > magnitude(z) ? a : magnitude(z);
  const Real s = scaleToOne(largest), A = a * s, Z = z * s, size = squareRoot(A * A + Z * Z);
  *real = size > 0 ? A / size : JULIA_REAL(1);
  *imaginary = size > 0 ? Z / size : JULIA_REAL(0);
}

JULIA_SHARED void squareComplex(Real* a, Real* b) {
  const Real real = *a * *a - *b * *b;
  *b = 2 * (*a * *b);
  *a = real;
}
JULIA_SHARED void multiplyComplex(Real a1, Real b1, Real* a, Real* b) {
  const Real real = *a * a1 - *b * b1;
  *b = *a * b1 + *b * a1;
  *a = real;
}

/// p times the angle of a + i b, from -2 to 2 quadrants.
JULIA_SHARED Real angleTimes(Real p, Real a, Real b) {
  // This close to the axis, the angle is effectively 0 or 2.
  const Real least = JULIA_REAL(1e-30), height = magnitude(b);
  Real unused;
  const Real quadrants = angleInQuadrants(a, height > least ? height : least, &unused);
  return p * (b < 0 ? -quadrants : quadrants);
}
