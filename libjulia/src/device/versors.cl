// SPDX-License-Identifier: Apache-2.0
// What an orbit reads at a point, in OpenCL C: fields of bricks and versors. device/program_text.cpp puts the words and
// the constants of kernels/language.h and the shared text of kernels/shared in front of it. Everything else computes
// as the processor does, in the same order of operations: roots and waves as in kernels/*_bodies.h, and versors made of
// them as in moved_versor.cpp, mixed_versor.cpp and vector_versor.cpp.
//
// The arrays are described in device/program_data.h.

typedef struct {
  __global const Real* numbers;
  __global const int* integers;
  __global const uint* places;
  __global const float* values;
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

#if MAP == MAP_SHAPE_MODULUS || MAP == MAP_RATIONAL
__global const int* latticeOf(Data data, int number) {
  return data.integers + data.integers[LATTICES_AT] + LATTICE_SIZE * number;
}
__global const int* nodeOf(Data data, int number) {
  return data.integers + data.integers[NODES_AT] + NODE_SIZE * number;
}

/// The number of a cell's brick in the lattice.
int brickOf(__global const int* lattice, const int* cell) {
  const int ny = lattice[LATTICE_BRICKS], nz = lattice[LATTICE_BRICKS + 1];
  return ((cell[0] >> 3) * ny + (cell[1] >> 3)) * nz + (cell[2] >> 3);
}

Real readTrilinear(__global const int* lattice, __global const uint* brickAt, __global const float* values,
                   const Real* at) {
  int cell[3];
  Real t[3];
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = (int)at[axis];
    t[axis] = at[axis] - (Real)cell[axis];
  }
  const int offset = ((cell[0] & 7) * 9 + (cell[1] & 7)) * 9 + (cell[2] & 7);
  __global const float* v = values + (size_t)brickAt[brickOf(lattice, cell)] * 729 + offset;
  return trilinear(v[0], v[1], v[9], v[10], v[81], v[82], v[90], v[91], t[0], t[1], t[2]);
}

Real readQuadratic(__global const int* lattice, __global const uint* brickAt, __global const float* values,
                   const Real* at) {
  int cell[3];
  Real weight[3][3];
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = (int)(at[axis] + JULIA_REAL(0.5));
    splineWeights(at[axis] - (Real)cell[axis], &weight[axis][0], &weight[axis][1], &weight[axis][2]);
  }
  const int offset = ((cell[0] & 7) * 10 + (cell[1] & 7)) * 10 + (cell[2] & 7);
  __global const float* value = values + (size_t)brickAt[brickOf(lattice, cell)] * 1000 + offset;
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

/// The field number @a number at q.
Real readField(Data data, int number, const Real* q) {
  __global const int* lattice = latticeOf(data, number);
  __global const Real* m = data.numbers + lattice[LATTICE_NUMBERS];
  __global const uint* brickAt = data.places + lattice[LATTICE_PLACES];
  const size_t first = ((size_t)lattice[LATTICE_VALUES + 1] << 31) + (size_t)lattice[LATTICE_VALUES];
  __global const float* values = data.values + first;
  Real at[3];
  for (int row = 0; row < 3; ++row)
    at[row] = latticePosition(m[3 * row], m[3 * row + 1], m[3 * row + 2], m[9 + row], m[12 + row], m[15 + row], q[X],
                              q[Y], q[Z]);
  const Real v = lattice[LATTICE_QUADRATIC] ? readQuadratic(lattice, brickAt, values, at)
                                            : readTrilinear(lattice, brickAt, values, at);
  return bent(v, m[18], m[19]);
}

Real guessedOrExact(int method, Real norm) {
  return method == METHOD_PRODUCTS ? guessedInverseRoot(norm) : 1 / squareRoot(norm);
}

/// Whether the squares are reliable.
bool isOrdinary(const Real* q, Real least) {
  return least >= JULIA_IEEE(kTiny) && sumOfSquares(q[0], q[1], q[2], q[3]) <= 1 / JULIA_IEEE(kTiny);
}

/// Sets u to the versor of the ordered product of the factors. Returns whether it is valid.
bool versorOfRoots(Data data, int number, const Real* q, Real* u) {
  __global const int* node = nodeOf(data, number);
  Real smallest = 1;
  u[0] = 1;
  u[1] = u[2] = u[3] = 0;
  for (int r = 0; r < node[NODE_COUNT]; ++r) {
    __global const Real* root = data.numbers + node[NODE_NUMBERS] + 5 * r;
    __global const int* how = data.integers + node[NODE_INTEGERS] + 3 * r;
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

#if MAP == MAP_RATIONAL
/// Sets l to ln|f(q)|. Returns whether it is valid.
bool logModulusOfRoots(Data data, const Real* q, Real* l) {
  __global const int* node = nodeOf(data, 0);
  Real smallest = 1, sum = data.numbers[SCALE];
  for (int r = 0; r < node[NODE_COUNT]; ++r) {
    __global const Real* root = data.numbers + node[NODE_NUMBERS] + 5 * r;
    const Real da = q[0] - root[0], db = q[1] - root[1], dc = q[2] - root[2], dd = q[3] - root[3];
    const Real norm = da * da + imaginarySquare(db, dc, dd);
    smallest = norm < smallest ? norm : smallest;
    sum += (root[4] * JULIA_REAL(0.5)) * logarithm(norm);
  }
  *l = sum;
  return isOrdinary(q, smallest);
}
#endif

void versorOfWaves(Data data, int number, const Real* q, Real* u) {
  __global const int* node = nodeOf(data, number);
  __global const Real* origin = data.numbers + node[NODE_NUMBERS];
  const Real read = readField(data, node[NODE_LATTICE], q);
  const Real most = MOST_OCTAVE;
  const Real octave = read < -most ? -most : most < read ? most : read;
  Real blend, scale, at[4], fine[4];
  splitOctave(octave, &blend, &scale);
  for (int c = 0; c < 4; ++c) {
    at[c] = (q[c] - origin[c]) * scale;
    u[c] = fine[c] = c == 0 ? 1 : 0;
  }
  for (int f = 0; f < node[NODE_COUNT]; ++f) {
    __global const int* factor = data.integers + node[NODE_INTEGERS] + 4 * f;
    const Real conjugated = (Real)factor[3];
    Real sum[4] = {0, 0, 0, 0}, sumFine[4] = {0, 0, 0, 0};
    for (int w = factor[0]; w < factor[1]; ++w) {
      __global const Real* wave = origin + 4 + 12 * w;
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

void versorOfGrain(Data data, int number, const Real* q, Real* u) {
  __global const int* node = nodeOf(data, number);
  __global const Real* waves = data.numbers + node[NODE_NUMBERS];
  Real read[5];
  for (int k = 0; k < 5; ++k) read[k] = readField(data, node[NODE_LATTICE] + k, q);
  Real alongCertain, acrossCertain;
  const Real along = certainPhase(read[0], read[1], &alongCertain);
  const Real across = certainPhase(read[2], read[3], &acrossCertain);
  const Real depth = read[4] * 4, certain = alongCertain * acrossCertain;
  for (int c = 0; c < 4; ++c) u[c] = c == 0 ? 1 : 0;
  for (int f = 0; f < node[NODE_COUNT]; ++f) {
    __global const int* factor = data.integers + node[NODE_INTEGERS] + 4 * f;
    const Real conjugated = (Real)factor[3];
    Real sum[4] = {0, 0, 0, 0};
    for (int w = factor[0]; w < factor[1]; ++w) {
      __global const Real* wave = waves + 12 * w;
      Real sine, cosine;
      sineCosine(grainPhase(wave[0], wave[1], wave[2], along, across, depth), &sine, &cosine);
      for (int c = 0; c < 4; ++c) sum[c] += wave[4 + c] * cosine + wave[8 + c] * sine;
    }
    makeUnit(sum[0], sum[1], sum[2], sum[3], &sum[0], &sum[1], &sum[2], &sum[3]);
    for (int times = 0; times < factor[2]; ++times)
      multiplyQuaternion(sum[0], conjugated * sum[1], conjugated * sum[2], conjugated * sum[3], &u[0], &u[1], &u[2],
                         &u[3]);
  }
  u[0] = fadedPart(u[0], JULIA_REAL(1), certain);
  for (int c = 1; c < 4; ++c) u[c] = fadedPart(u[c], JULIA_REAL(0), certain);
  makeUnit(u[0], u[1], u[2], u[3], &u[0], &u[1], &u[2], &u[3]);
}

/// The component of q that is a coordinate of space.
int componentOf(int axis) { return axis == 0 ? X : axis == 1 ? Y : Z; }

/// Sets u to the versor of three or four fields.
void versorOfFields(Data data, int number, const Real* q, Real* u) {
  __global const int* node = nodeOf(data, number);
  const int count = node[NODE_COUNT];
  Real v[4] = {0, 0, 0, 0};
  for (int k = 0; k < count; ++k) v[count == 3 ? componentOf(k) : k] = readField(data, node[NODE_LATTICE] + k, q);
  makeDirection(v[0], v[1], v[2], v[3], &u[0], &u[1], &u[2], &u[3]);
}

/// Sets @a to to the place where a moved versor is read.
void moveBack(Data data, int number, const Real* q, Real* to) {
  __global const Real* by = data.numbers + nodeOf(data, number)[NODE_NUMBERS];
  for (int c = 0; c < 4; ++c) to[c] = movedBack(q[c], by[c], by[4]);
}

/// Sets @a to to q, folded into the half-space or the sector of a symmetry.
void foldInto(Data data, int number, const Real* q, Real* to) {
  __global const int* node = nodeOf(data, number);
  __global const int* how = data.integers + node[NODE_INTEGERS];
  __global const Real* centre = data.numbers + node[NODE_NUMBERS];
  __global const Real* turns = centre + 3;
  for (int c = 0; c < 4; ++c) to[c] = q[c];
  for (int axis = 0; axis < 3; ++axis) {
    const int c = componentOf(axis);
    if (how[SYMMETRY_MIRRORED] >> axis & 1) to[c] = mirroredUp(to[c], centre[axis]);
  }
  if (!how[SYMMETRY_KALEIDOSCOPE]) return;
  const int first = (how[SYMMETRY_AXIS] + 1) % 3, second = (first + 1) % 3;
  Real x = to[componentOf(first)] - centre[first], y = to[componentOf(second)] - centre[second];
  int nearest = 0;
  Real most = x;
  for (int k = 1; k < node[NODE_COUNT]; ++k) {
    const Real along = reachAlong(turns[2 * k], turns[2 * k + 1], x, y);
    if (along > most) {
      most = along;
      nearest = k;
    }
  }
  turnBy(turns[2 * nearest], turns[2 * nearest + 1], &x, &y);
  to[componentOf(first)] = x + centre[first];
  to[componentOf(second)] = magnitude(y) + centre[second];
}

/// Sets @a to to q, turned to another sector of a symmetry.
void turnTo(Data data, int number, int sector, const Real* q, Real* to) {
  __global const int* node = nodeOf(data, number);
  __global const Real* centre = data.numbers + node[NODE_NUMBERS];
  __global const Real* by = centre + 3 + 2 * sector;
  const int first = (data.integers[node[NODE_INTEGERS] + SYMMETRY_AXIS] + 1) % 3, second = (first + 1) % 3;
  for (int c = 0; c < 4; ++c) to[c] = q[c];
  Real x = to[componentOf(first)] - centre[first], y = to[componentOf(second)] - centre[second];
  turnBy(by[0], by[1], &x, &y);
  to[componentOf(first)] = x + centre[first];
  to[componentOf(second)] = y + centre[second];
}

// OpenCL C has no recursion and no pointers to functions, so each node of a texture is a function that these words
// define. It sets u to the versor at q and returns whether it is valid.
#define ROOTS_VERSOR(name, node) \
  bool name(Data data, const Real* q, Real* u) { return versorOfRoots(data, node, q, u); }
#define WAVES_VERSOR(name, node)                 \
  bool name(Data data, const Real* q, Real* u) { \
    versorOfWaves(data, node, q, u);             \
    return true;                                 \
  }
#define GRAIN_VERSOR(name, node)                 \
  bool name(Data data, const Real* q, Real* u) { \
    versorOfGrain(data, node, q, u);             \
    return true;                                 \
  }
#define FIELDS_VERSOR(name, node)                \
  bool name(Data data, const Real* q, Real* u) { \
    versorOfFields(data, node, q, u);            \
    return true;                                 \
  }
#define MOVED_VERSOR(name, node, of)             \
  bool name(Data data, const Real* q, Real* u) { \
    Real at[4];                                  \
    moveBack(data, node, q, at);                 \
    return of(data, at, u);                      \
  }
#define FOLDED_VERSOR(name, node, of)            \
  bool name(Data data, const Real* q, Real* u) { \
    Real at[4];                                  \
    foldInto(data, node, q, at);                 \
    return of(data, at, u);                      \
  }
#define TURNED_VERSOR(name, node, of)                                                    \
  bool name(Data data, const Real* q, Real* u) {                                         \
    Real at[4];                                                                          \
    foldInto(data, node, q, at);                                                         \
    bool valid = of(data, at, u);                                                        \
    for (int sector = 1; sector < nodeOf(data, node)[NODE_COUNT]; ++sector) {            \
      Real there[4], one[4];                                                             \
      turnTo(data, node, sector, at, there);                                             \
      if (!of(data, there, one)) valid = false;                                          \
      for (int c = 0; c < 4; ++c) u[c] = u[c] + one[c];                                  \
    }                                                                                    \
    makeDirection(u[0], u[1], u[2], u[3], &u[0], &u[1], &u[2], &u[3]);                   \
    return valid;                                                                        \
  }
#define MIXED_VERSOR(name, node, under, over)                                            \
  bool name(Data data, const Real* q, Real* u) {                                         \
    const Real mix = readField(data, nodeOf(data, node)[NODE_LATTICE], q);               \
    if (mix <= 0) return under(data, q, u);                                              \
    if (mix >= 1) return over(data, q, u);                                               \
    Real v[4];                                                                           \
    bool valid = under(data, q, u);                                                      \
    if (!over(data, q, v)) valid = false;                                                \
    for (int c = 0; c < 4; ++c) u[c] = mixedPart(u[c], v[c], mix);                       \
    makeDirection(u[0], u[1], u[2], u[3], &u[0], &u[1], &u[2], &u[3]);                   \
    return valid;                                                                        \
  }
#endif
