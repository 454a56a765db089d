// SPDX-License-Identifier: Apache-2.0
// The orbit of one point, as docs/design.md 2.3 defines it, in OpenCL C. device/program_text.cpp puts the words and the
// constants of kernels/language.h and the shared text of kernels/shared in front of it. What a point needs beyond the
// shared text, the order of its operations included, is that of the kernels' loops (kernels/*_bodies.h).
//
// device/program_data.h says what MAP and VERSOR stand for, and what `numbers` and `integers` hold.

typedef struct {
  __global const Real* numbers;
  __global const int* integers;
  __global const uint* exponentBricks;
  __global const float* exponentValues;
  __global const uint* octaveBricks;
  __global const float* octaveValues;
} Data;

// The components of q at which fields over space are read.
#if DROPPED == 0
#define X 0
#define Y 2
#define Z 3
#define S 1
#elif DROPPED == 1
#define X 0
#define Y 1
#define Z 3
#define S 2
#else
#define X 0
#define Y 1
#define Z 2
#define S 3
#endif

#if MAP == MAP_SHAPE_MODULUS
Real readTrilinear(__global const int* bricks, __global const uint* brickAt,
                   __global const float* values, const Real* at) {
  int cell[3];
  Real t[3];
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = (int)at[axis];
    t[axis] = at[axis] - (Real)cell[axis];
  }
  const int brick = ((cell[0] >> 3) * bricks[0] + (cell[1] >> 3)) * bricks[1] + (cell[2] >> 3);
  const int offset = ((cell[0] & 7) * 9 + (cell[1] & 7)) * 9 + (cell[2] & 7);
  __global const float* v = values + (size_t)brickAt[brick] * 729 + offset;
  return trilinear(v[0], v[1], v[9], v[10], v[81], v[82], v[90], v[91], t[0], t[1], t[2]);
}

Real readQuadratic(__global const int* bricks, __global const uint* brickAt,
                   __global const float* values, const Real* at) {
  int cell[3];
  Real weight[3][3];
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = (int)(at[axis] + JULIA_REAL(0.5));
    splineWeights(at[axis] - (Real)cell[axis], &weight[axis][0], &weight[axis][1], &weight[axis][2]);
  }
  const int brick = ((cell[0] >> 3) * bricks[0] + (cell[1] >> 3)) * bricks[1] + (cell[2] >> 3);
  const int offset = ((cell[0] & 7) * 10 + (cell[1] & 7)) * 10 + (cell[2] & 7);
  __global const float* value = values + (size_t)brickAt[brick] * 1000 + offset;
  Real sum = 0;
  for (int dx = 0; dx < 3; ++dx) {
    Real face = 0;
    for (int dy = 0; dy < 3; ++dy, value += 10) {
      const Real edge = weightedSum(value[0], value[1], value[2], weight[2][0], weight[2][1], weight[2][2]);
      face += edge * weight[1][dy];
    }
    sum += face * weight[0][dx];
    value += 100 - 30;
  }
  return sum;
}

Real readLattice(__global const Real* lattice, __global const int* bricks, __global const uint* brickAt,
                 __global const float* values, int quadratic, const Real* q) {
  Real at[3];
  for (int row = 0; row < 3; ++row) {
    __global const Real* m = lattice + 3 * row;
    at[row] =
        latticePosition(m[0], m[1], m[2], lattice[9 + row], lattice[12 + row], lattice[15 + row], q[X], q[Y], q[Z]);
  }
  return quadratic ? readQuadratic(bricks, brickAt, values, at)
                   : readTrilinear(bricks, brickAt, values, at);
}
#endif

#if VERSOR == VERSOR_ROOTS
Real guessedOrExact(int method, Real norm) {
  return method == METHOD_PRODUCTS ? guessedInverseRoot(norm) : 1 / squareRoot(norm);
}

/// Whether the squares are reliable.
bool isOrdinary(const Real* q, Real least) {
  return least >= JULIA_IEEE(kTiny) && sumOfSquares(q[0], q[1], q[2], q[3]) <= 1 / JULIA_IEEE(kTiny);
}

/// Sets u to the versor of the ordered product of the factors. Returns whether it is valid.
bool versorOfRoots(Data data, const Real* q, Real* u) {
  Real smallest = 1;
  u[0] = 1;
  u[1] = u[2] = u[3] = 0;
  for (int r = 0; r < data.integers[COUNT]; ++r) {
    __global const Real* root = data.numbers + LIST + 5 * r;
    __global const int* how = data.integers + INTEGER_LIST + 3 * r;
    const Real da = q[0] - root[0], db = q[1] - root[1], dc = q[2] - root[2], dd = q[3] - root[3], power = root[4];
    const Real square = imaginarySquare(db, dc, dd);
    Real real, imaginary;
    if (how[0] == METHOD_ANGLE) {
      smallest = square < smallest ? square : smallest;
      Real inverse, sine;
      const Real angle = power * angleInQuadrants(da, squareRoot(square), &inverse);
      sineCosine(angle, &sine, &real);
      imaginary = sine * inverse;
    } else {
      const Real norm = da * da + square;
      smallest = norm < smallest ? norm : smallest;
      const Real by = guessedOrExact(how[0], norm), a = da * by, s = square * (by * by);
      const uint integer = (uint)how[1];
      real = a;
      imaginary = 1;
      for (int bit = 30 - (int)clz(integer); bit >= 0; --bit) {
        if (integer >> bit & 1)
          squareAndMultiplyFactor(a, s, &real, &imaginary);
        else
          squareFactor(s, &real, &imaginary);
      }
      imaginary *= by;
      if (power < 0) imaginary = -imaginary;
    }
    multiplyQuaternion(real, db * imaginary, dc * imaginary, dd * imaginary, &u[0], &u[1], &u[2], &u[3]);
    if (how[2]) {
      const Real by = guessedInverseRoot(sumOfSquares(u[0], u[1], u[2], u[3]));
      for (int k = 0; k < 4; ++k) u[k] = u[k] * by;
    }
  }
  const Real by = 1 / squareRoot(sumOfSquares(u[0], u[1], u[2], u[3]));
  for (int k = 0; k < 4; ++k) u[k] = u[k] * by;
  return isOrdinary(q, smallest);
}
#endif

#if MAP == MAP_RATIONAL
/// Sets l to ln|f(q)|. Returns whether it is valid.
bool logModulusOfRoots(Data data, const Real* q, Real* l) {
  Real smallest = 1, sum = data.numbers[SCALE];
  for (int r = 0; r < data.integers[COUNT]; ++r) {
    __global const Real* root = data.numbers + LIST + 5 * r;
    const Real da = q[0] - root[0], db = q[1] - root[1], dc = q[2] - root[2], dd = q[3] - root[3];
    const Real norm = da * da + imaginarySquare(db, dc, dd);
    smallest = norm < smallest ? norm : smallest;
    sum += (root[4] * JULIA_REAL(0.5)) * logarithm(norm);
  }
  *l = sum;
  return isOrdinary(q, smallest);
}
#endif

#if VERSOR == VERSOR_WAVES
void versorOfWaves(Data data, const Real* q, Real* u) {
  const Real read = readLattice(data.numbers + OCTAVE, data.integers + OCTAVE_BRICKS, data.octaveBricks,
                                data.octaveValues, data.integers[OCTAVE_QUADRATIC], q);
  const Real most = MOST_OCTAVE;
  const Real octave = read < -most ? -most : most < read ? most : read;
  Real blend, scale, at[4], fine[4];
  splitOctave(octave, &blend, &scale);
  for (int c = 0; c < 4; ++c) {
    at[c] = (q[c] - data.numbers[CONSTANT + c]) * scale;
    u[c] = fine[c] = c == 0 ? 1 : 0;
  }
  for (int number = 0; number < data.integers[COUNT]; ++number) {
    __global const int* factor = data.integers + INTEGER_LIST + 4 * number;
    const Real conjugated = (Real)factor[3];
    Real sum[4] = {0, 0, 0, 0}, sumFine[4] = {0, 0, 0, 0};
    for (int w = factor[0]; w < factor[1]; ++w) {
      __global const Real* wave = data.numbers + LIST + 12 * w;
      const Real phase = wavePhase(wave[0], wave[1], wave[2], wave[3], at[0], at[1], at[2], at[3]);
      Real sine, cosine, sineFine, cosineFine;
      sineCosine(phase, &sine, &cosine);
      doublePhase(sine, cosine, &sineFine, &cosineFine);
      for (int c = 0; c < 4; ++c) {
        sum[c] += wave[4 + c] * cosine + wave[8 + c] * sine;
        sumFine[c] += wave[4 + c] * cosineFine + wave[8 + c] * sineFine;
      }
    }
    makeUnit(sum[0], sum[1], sum[2], sum[3], &sum[0], &sum[1], &sum[2], &sum[3]);
    makeUnit(sumFine[0], sumFine[1], sumFine[2], sumFine[3], &sumFine[0], &sumFine[1], &sumFine[2], &sumFine[3]);
    for (int times = 0; times < factor[2]; ++times) {
      multiplyQuaternion(sum[0], conjugated * sum[1], conjugated * sum[2], conjugated * sum[3], &u[0], &u[1], &u[2],
                         &u[3]);
      multiplyQuaternion(sumFine[0], conjugated * sumFine[1], conjugated * sumFine[2], conjugated * sumFine[3],
                         &fine[0], &fine[1], &fine[2], &fine[3]);
    }
  }
  for (int c = 0; c < 4; ++c) u[c] = u[c] + blend * (fine[c] - u[c]);
  makeUnit(u[0], u[1], u[2], u[3], &u[0], &u[1], &u[2], &u[3]);
}
#endif

#if MAP == MAP_TRIPLEX
void complexPower(uint n, Real* a, Real* b) {
  const Real a1 = *a, b1 = *b;
  for (int bit = 30 - (int)clz(n); bit >= 0; --bit) {
    squareComplex(a, b);
    if (n >> bit & 1) multiplyComplex(a1, b1, a, b);
  }
}

void unitPower(Real p, Real* a, Real* b) {
  const Real angle = angleTimes(p, *a, *b);
  sineCosine(angle, b, a);
}
#endif

#if MAP >= MAP_QUADRATIC
/// next = the image of p. @param carried  what the map carries for the orbit: the constant, or a factor
void stepOf(Data data, int first, const Real* p, Real* carried, Real* next) {
#if MAP == MAP_QUADRATIC
  squareQuaternion(p[0], p[1], p[2], p[3], &next[0], &next[1], &next[2], &next[3]);
  for (int k = 0; k < 4; ++k) next[k] = next[k] + carried[k];
#elif MAP == MAP_TRIPLEX
  const Real power = data.numbers[SCALE];
  const uint integer = (uint)data.integers[COUNT];
  const Real atZero = power > 0 ? JULIA_REAL(0) : power < 0 ? JULIA_INFINITY : JULIA_REAL(1);
  Real u, v, a, b, length = 1;
  azimuthOf(p[0], p[1], &u, &v, &a);
  if (integer == 0) {
    length = powerOfRadius(power * JULIA_REAL(0.5), atZero, a, p[2]);
    unitComplex(a, p[2], &a, &b);
  } else {
    b = p[2];
  }
  Real* real = data.integers[FROM_POLE] ? &b : &a;
  Real* imaginary = data.integers[FROM_POLE] ? &a : &b;
  if (integer != 0) {
    complexPower(integer, &u, &v);
    complexPower(integer, real, imaginary);
  } else {
    unitPower(power, &u, &v);
    unitPower(power, real, imaginary);
    a *= length;
    b *= length;
  }
  next[0] = a * u + carried[0];
  next[1] = a * v + carried[1];
  next[2] = b + carried[2];
  next[3] = 0;
#else
  const int pair = data.integers[PAIR];
  if (FIXED_FACTOR) {
    if (first) {
      switch (pair) {
        case 0: secondOfA(1, p[0], p[1], p[2], &carried[0], &carried[1], &carried[2]); break;
        case 1: secondOfA(-1, p[0], p[1], p[2], &carried[0], &carried[1], &carried[2]); break;
        case 2:
        case 3: secondOfB(p[0], p[1], p[2], &carried[0], &carried[1], &carried[2]); break;
        case 4:
          carried[0] = carried[1] = 0;
          carried[2] = 1;
          break;
        default: carried[0] = carried[2] = 1; carried[1] = cosineOfRadians(p[2]);
      }
    } else {
      crossOf(p[0], p[1], p[2], carried[0], carried[1], carried[2], &next[0], &next[1], &next[2]);
      for (int k = 0; k < 3; ++k) next[k] = next[k] + 0;
      next[3] = 0;
      return;
    }
  }
  switch (pair) {
    case 0: productOfA(1, p[0], p[1], p[2], &next[0], &next[1], &next[2]); break;
    case 1: productOfA(-1, p[0], p[1], p[2], &next[0], &next[1], &next[2]); break;
    case 2: productOfB(p[0], p[1], p[2], &next[0], &next[1], &next[2]); break;
    case 3: productOfC(p[0], p[1], p[2], &next[0], &next[1], &next[2]); break;
    case 4: productOfD(p[0], p[1], p[2], &next[0], &next[1], &next[2]); break;
    default: productOfE(p[0], p[1], p[2], &next[0], &next[1], &next[2]);
  }
  for (int k = 0; k < 3; ++k) next[k] = next[k] + (FIXED_FACTOR ? JULIA_REAL(0) : carried[k]);
  next[3] = 0;
#endif
}

/// Sets l to ln|q|. Returns whether it is valid.
bool logNormOf(const Real* q, Real* l) {
  const Real norm = q[0] * q[0] + imaginarySquare(q[1], q[2], q[3]);
  *l = JULIA_REAL(0.5) * logarithm(norm);
  return norm >= 2 * JULIA_IEEE(kTiny) && norm <= JULIA_IEEE(kHuge);
}
#endif

/// Follows the orbit of a point of space and sets *end to its last l. Returns the number of steps or, where the processor
/// has to look at the point, -1.
int followOrbit(Data data, Real x, Real y, Real z, Real* end) {
  __global const Real* numbers = data.numbers;
  const Real slice = numbers[SLICE], near = numbers[NEAR_SQUARED];
  const Real escape = numbers[LOG_ESCAPE], trap = numbers[LOG_TRAP];
  const int most = data.integers[MOST_STEPS];
  Real q[4];
  q[X] = x;
  q[Y] = y;
  q[Z] = z;
  q[S] = slice;
  bool valid = q[X] * q[X] + q[Y] * q[Y] + q[Z] * q[Z] + slice * slice < near;
  Real l = 0;
  int step = 0;
#if MAP >= MAP_QUADRATIC
  Real carried[4];
  for (int k = 0; k < 4; ++k) carried[k] = OWN_CONSTANT ? q[k] : numbers[CONSTANT + k];
#endif
  while (valid) {
    ++step;
    Real next[4];
#if MAP == MAP_SHAPE_MODULUS
    l = readLattice(numbers + EXPONENT, data.integers + EXPONENT_BRICKS, data.exponentBricks, data.exponentValues,
                    data.integers[EXPONENT_QUADRATIC], q);
#elif MAP == MAP_RATIONAL
    valid = logModulusOfRoots(data, q, &l);
#else
    stepOf(data, step == 1, q, carried, next);
    valid = logNormOf(next, &l);
#endif
    if (!valid || step == most || !(l < escape) || (TRAPS && !(l > trap))) break;
#if VERSOR == VERSOR_ROOTS
    valid = versorOfRoots(data, q, next);
#elif VERSOR == VERSOR_WAVES
    versorOfWaves(data, q, next);
#elif VERSOR == VERSOR_VALUE
    // The map's value, by its length.
    const Real by = 1 / squareRoot(next[0] * next[0] + imaginarySquare(next[1], next[2], next[3]));
    for (int k = 0; k < 4; ++k) next[k] = next[k] * by;
#endif
#if VERSOR != VERSOR_NONE
    const Real length = exponential(l);
    for (int k = 0; k < 4; ++k) next[k] = next[k] * length;
#endif
    for (int k = 0; k < 4; ++k) q[k] = next[k];
  }
  *end = l;
  return valid ? step : -1;
}

/// Follows the orbits of @a count points: ends[i] is the last l, steps[i] what followOrbit() returns.
__kernel void followOrbits(__global const Real* points, __global Real* ends, __global int* steps, uint count,
                           __global const Real* numbers, __global const int* integers,
                           __global const uint* exponentBricks, __global const float* exponentValues,
                           __global const uint* octaveBricks, __global const float* octaveValues) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Data data = {numbers, integers, exponentBricks, exponentValues, octaveBricks, octaveValues};
  __global const Real* point = points + 3 * (size_t)i;
  Real end;
  steps[i] = followOrbit(data, point[0], point[1], point[2], &end);
  ends[i] = end;
}

#if SEARCHES
/// Sets *field to F at a point. Returns whether it is valid.
bool fieldAt(Data data, const double* at, double* field) {
  Real end;
  if (followOrbit(data, (Real)at[0], (Real)at[1], (Real)at[2], &end) < 0) return false;
  const double value = (double)(end - data.numbers[LEVEL]);
  const double above = value > -FIELD_LIMIT ? value : -FIELD_LIMIT;
  *field = above < FIELD_LIMIT ? above : FIELD_LIMIT;
  return true;
}

/// The coordinate of a place in index space. @param lattice  voxel size, scale, centre
double coordinateAt(__global const double* lattice, double index, int axis) {
  return (index * lattice[0] - lattice[2 + axis]) / lattice[1];
}

/// Finds where F changes its sign on @a count edges, in voxels from their beginnings, or -1 where the processor has to
/// look at an edge: FieldEvaluator::findCrossings(), edge by edge.
/// @param edges   six numbers of each: its beginning, the index there, F at its ends
/// @param width   of a bracket that is narrow enough
/// @param widest  that a bracket may be after the first round
__kernel void searchEdges(__global const double* edges, __global const int* axes, __global double* found, uint count,
                          __global const Real* numbers, __global const int* integers,
                          __global const uint* exponentBricks, __global const float* exponentValues,
                          __global const uint* octaveBricks, __global const float* octaveValues,
                          __global const double* lattice, double width, double widest) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Data data = {numbers, integers, exponentBricks, exponentValues, octaveBricks, octaveValues};
  __global const double* edge = edges + 6 * (size_t)i;
  const int axis = axes[i];
  const double index = edge[3], from = edge[4], to = edge[5];
  double at[3] = {edge[0], edge[1], edge[2]};
  double low = 0, high = 1, atLow = damped(from), atHigh = damped(to), field;
  if (!(from < STORED_FIELD_LIMIT && to < STORED_FIELD_LIMIT)) {
    const bool atEnd = to >= STORED_FIELD_LIMIT;
    if (atEnd) at[axis] = coordinateAt(lattice, index + 1, axis);
    if (!fieldAt(data, at, &field)) {
      found[i] = -1;
      return;
    }
    // As it would have been stored.
    float stored = (float)field;
    if (stored == 0 && field < 0) stored = -LEAST_STORED;
    if (atEnd)
      atHigh = damped((double)stored);
    else
      atLow = damped((double)stored);
  }
  for (; high - low > width; widest = widest / 2) {
    const double next = nextPoint(low, high, atLow, atHigh, widest);
    at[axis] = coordinateAt(lattice, index + next, axis);
    if (!fieldAt(data, at, &field)) {
      found[i] = -1;
      return;
    }
    if ((field < 0) == (atLow < 0)) {
      low = next;
      atLow = damped(field);
    } else {
      high = next;
      atHigh = damped(field);
    }
  }
  found[i] = low + (high - low) / 2;
}
#endif

/// What betrays arithmetic that is not IEEE 754's: fused operations, flushed denormal numbers, rough quotients and
/// roots.
__kernel void tryArithmetic(__global const Real* x, __global const Real* y, __global const Real* z, __global Real* out,
                            uint count) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  out[6 * i] = x[i] * y[i] + z[i];
  out[6 * i + 1] = x[i] / y[i];
  out[6 * i + 2] = squareRoot(magnitude(x[i]));
  out[6 * i + 3] = x[i] * y[i];
  out[6 * i + 4] = z[i] - x[i] * y[i];
  out[6 * i + 5] = x[i] * y[i] * z[i];
}
