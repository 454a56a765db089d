// SPDX-License-Identifier: Apache-2.0
#include "cartesian_balls.h"

#include "ball_arithmetic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace julia {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// The rounding errors of Real in a product of the kernels, as a multiple of the largest summand: a dozen roundings,
/// and cosines that are accurate to 8 ulp of 1.
constexpr double kRoundings = 64;

double power(double x, int n) {
  double result = 1;
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) result *= x;
    x *= x;
  }
  return result;
}

struct Complex {
  double a, b;
};

Complex power(Complex x, int n) {
  Complex result{1, 0};
  const auto times = [](Complex s, Complex t) { return Complex{s.a * t.a - s.b * t.b, s.a * t.b + s.b * t.a}; };
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) result = times(result, x);
    x = times(x, x);
  }
  return result;
}

/// A point and the ball around it in the coordinates of [ZB25] Eq. 1.
struct Spherical {
  double r, level;         ///< level: the distance from the z axis
  Complex phi;             ///< e^(i phi)
  double most;             ///< maximum of r over the ball
  double leastCosine = 0;  ///< minimum of cos theta over the ball; 0 if it may touch the z axis

  explicit Spherical(const Ball& ball) {
    const double x = ball.centre.a, y = ball.centre.b, z = ball.centre.c;
    level = std::sqrt(x * x + y * y);
    r = std::sqrt(x * x + y * y + z * z);
    phi = level > 0 ? Complex{x / level, y / level} : Complex{1, 0};
    most = r + ball.radius;
    if (!(ball.radius < r)) return;
    // The sum of |theta| and the angular radius of the ball as seen from 0.
    const double away = std::sqrt((r - ball.radius) * (r + ball.radius));
    const double cosine = (level * away - std::abs(z) * ball.radius) / (r * r);
    leastCosine = std::max(0., cosine - 16 * kSlack);
  }
};

/// @param stretch  the largest derivative over the ball
/// @param least    the ball of this radius about 0 contains the image as well
/// @param size     the rounding errors are multiples of this
template <class Real>
Ball image(const Ball& ball, const Quaternion<double>& centre, double stretch, double size, double roundings,
           double about0 = kUnbounded) {
  const double rounding = (roundings * kEpsilonOf<Real> + roundings * kSlack) * size + kVanishing<Real>;
  const double radius = (1 + kSlack) * stretch * ball.radius + rounding;
  if (radius < about0) return {centre, radius};
  return {{}, (1 + kSlack) * about0 + rounding};
}

struct Sides {
  double x, y, z;  ///< maxima of |x|, |y|, |z| over the ball
  explicit Sides(const Ball& ball)
      : x(std::abs(ball.centre.a) + ball.radius),
        y(std::abs(ball.centre.b) + ball.radius),
        z(std::abs(ball.centre.c) + ball.radius) {}
};

double cosine(double x) { return kernels::cosineOfRadians(x); }

/// The Frobenius norm of a matrix, an upper bound of its norm.
double norm(const std::array<double, 9>& matrix) {
  double sum = 0;
  for (const double entry : matrix) sum += entry * entry;
  return std::sqrt(sum);
}

Quaternion<double> cross(const Quaternion<double>& f, const Quaternion<double>& g) {
  return {f.b * g.c - f.c * g.b, f.c * g.a - f.a * g.c, f.a * g.b - f.b * g.a, 0};
}

double largest(const Ball& ball) { return julia::norm(ball.centre) + ball.radius; }

/// (gz - gy, gx - gz, gy - gx): differences have the Lipschitz constant sqrt(3), cosines 1.
template <class Real>
Ball productB(const Ball& ball) {
  const double x = cosine(ball.centre.a), y = cosine(ball.centre.b), z = cosine(ball.centre.c);
  constexpr double kStretch = 1.7320508075688774;
  return image<Real>(ball, {z - y, x - z, y - x, 0}, kStretch, 1, kRoundings, 2 * kStretch);
}

template <class Real>
Ball productC(const Ball& ball) {
  const auto [x, y, z, none] = ball.centre;
  const Sides most(ball);
  const double X = most.x, Y = most.y, Z = most.z;
  const auto sine = [](double side) { return std::min(1., side); };
  const double stretch = norm({0, 2 * Y + Z * Z * sine(Y), 2 * Z + Y * Y * sine(Z),  //
                               2 * X + Z * Z * sine(X), 0, 2 * Z + X * X * sine(Z),  //
                               2 * X + Y * Y * sine(X), 2 * Y + X * X * sine(Y), 0});
  return image<Real>(ball, cross({x * x, y * y, z * z, 0}, {cosine(x), cosine(y), cosine(z), 0}), stretch,
                     X * X + Y * Y + Z * Z, kRoundings);
}

/// r^2 (cos 2phi, sin 2phi, 0) has the derivatives 2r along r, and 2r / cos theta along phi.
template <class Real>
Ball productD(const Ball& ball) {
  const Spherical at(ball);
  const double square = at.r * at.r, most = at.most * at.most;
  const Complex twice = power(at.phi, 2);
  return image<Real>(ball, {square * twice.a, square * twice.b, 0, 0},
                     at.leastCosine > 0 ? 2 * at.most / at.leastCosine : kUnbounded, most, kRoundings, most);
}

template <class Real>
Ball productE(const Ball& ball) {
  const auto [x, y, z, none] = ball.centre;
  const Sides most(ball);
  const double X = most.x, Y = most.y, Z = most.z, sine = std::min(1., Z);
  const double stretch = norm({0, 2 * Y, 2 * Z + Z * Z * sine,  //
                               2 * X * Y, X * X, 2 * Z,         //
                               2 * X * Y, X * X + 2 * Y, X * X * Y * sine});
  return image<Real>(ball, cross({x * x * y, y * y, z * z, 0}, {1, cosine(z), 1, 0}), stretch,
                     X * X * (1 + Y) + Y * Y + Z * Z, kRoundings);
}

}  // namespace

/// (q + d)^2 = q^2 + (q d + d q) + d^2.
template <class Real>
Ball squareOf(const Ball& ball) {
  const double most = largest(ball);
  return image<Real>(ball, ball.centre * ball.centre, julia::norm(ball.centre) + most, most * most, kRoundings);
}

/// With the angle theta above the plane, the images of the unit vectors along r, theta and phi are orthogonal, too.
/// Their lengths are n r^(n-1) for the first two, and that times |cos n theta| / cos theta for the third: at most 1 /
/// cos theta, and at most n if n is odd. For n = 2 the factor is |2 cos theta - 1 / cos theta|. With the angle from the
/// pole it is |sin n theta| / sin theta, at most n.
template <class Real>
Ball triplexPowerOf(int n, TriplexAngle angle, const Ball& ball) {
  const Spherical at(ball);
  const bool fromPole = angle == TriplexAngle::FromPole;
  const double z = ball.centre.c, c = at.leastCosine;
  const Complex around = power(at.phi, n);
  const Complex above = power(fromPole ? Complex{z, at.level} : Complex{at.level, z}, n);
  const double across = fromPole ? above.b : above.a, height = fromPole ? above.a : above.b;
  double turn = c > 0 ? 1 / c : kUnbounded;
  if (n == 2 && !fromPole && c > 0) turn -= 2 * c;
  if (fromPole || n % 2 == 1) turn = std::min(turn, static_cast<double>(n));
  const double most = power(at.most, n - 1), stretch = n * most * std::max(1., turn);
  // Each rounding error of the angles is multiplied by n.
  return image<Real>(ball, {across * around.a, across * around.b, height, 0}, stretch, most * at.most, kRoundings * n,
                     most * at.most);
}

template <class Real>
std::optional<Ball> crossProductOf(CrossPair pair, const Ball& ball) {
  switch (pair) {
    case CrossPair::A: return triplexPowerOf<Real>(2, TriplexAngle::AbovePlane, ball);
    case CrossPair::APrime: {
      Ball mirrored = triplexPowerOf<Real>(2, TriplexAngle::AbovePlane, ball);
      mirrored.centre.c = -mirrored.centre.c;
      return mirrored;
    }
    case CrossPair::B: return productB<Real>(ball);
    case CrossPair::C: return productC<Real>(ball);
    case CrossPair::D: return productD<Real>(ball);
    case CrossPair::E: return productE<Real>(ball);
    case CrossPair::User: break;
  }
  return std::nullopt;
}

template <class Real>
std::optional<Ball> crossSecondOf(CrossPair pair, const Ball& ball) {
  const auto [x, y, z, none] = ball.centre;
  switch (pair) {
    case CrossPair::A:
    case CrossPair::APrime: break;
    case CrossPair::B:
    case CrossPair::C: return image<Real>(ball, {cosine(x), cosine(y), cosine(z), 0}, 1, 1, kRoundings);
    case CrossPair::D: return Ball{{0, 0, 1, 0}, 0};
    case CrossPair::E: return image<Real>(ball, {1, cosine(z), 1, 0}, 1, 1, kRoundings);
    case CrossPair::User: break;
  }
  return std::nullopt;
}

template <class Real>
Ball crossProductOf(const Ball& p, const Ball& g) {
  // (p + d) x (g + e) = p x g + d x (g + e) + p x e
  const double size = largest(p) * largest(g);
  const double radius = (1 + kSlack) * (p.radius * largest(g) + julia::norm(p.centre) * g.radius);
  return {cross(p.centre, g.centre), radius + (kRoundings * (kEpsilonOf<Real> + kSlack)) * size + kVanishing<Real>};
}

template <class Real>
Ball sumOf(const Ball& a, const Ball& b) {
  const double size = largest(a) + largest(b);
  return {a.centre + b.centre,
          (1 + kSlack) * (a.radius + b.radius) + 2 * (kEpsilonOf<Real> + kSlack) * size + kVanishing<Real>};
}

template Ball squareOf<float>(const Ball&);
template Ball squareOf<double>(const Ball&);
template Ball triplexPowerOf<float>(int, TriplexAngle, const Ball&);
template Ball triplexPowerOf<double>(int, TriplexAngle, const Ball&);
template std::optional<Ball> crossProductOf<float>(CrossPair, const Ball&);
template std::optional<Ball> crossProductOf<double>(CrossPair, const Ball&);
template std::optional<Ball> crossSecondOf<float>(CrossPair, const Ball&);
template std::optional<Ball> crossSecondOf<double>(CrossPair, const Ball&);
template Ball crossProductOf<float>(const Ball&, const Ball&);
template Ball crossProductOf<double>(const Ball&, const Ball&);
template Ball sumOf<float>(const Ball&, const Ball&);
template Ball sumOf<double>(const Ball&, const Ball&);

}  // namespace julia
