// SPDX-License-Identifier: Apache-2.0
// The orbit of one point, as docs/design.md 2.3 defines it, in OpenCL C. versors.cl and the functions of the field's
// texture, the last of which is versorOfTexture(), come before it.
//
// The macros MAP and VERSOR, `numbers` and `integers` are described in device/program_data.h.

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
  const uint integer = (uint)data.integers[POWER];
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

/// Follows the orbit of a point of space and sets *end to its last l. Returns the number of steps or, where the
/// processor has to look at the point, -1.
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
    l = readField(data, 0, q);
#elif MAP == MAP_RATIONAL
    valid = logModulusOfRoots(data, q, &l);
#else
    stepOf(data, step == 1, q, carried, next);
    valid = logNormOf(next, &l);
#endif
    if (!valid || step == most || !(l < escape) || (TRAPS && !(l > trap))) break;
#if VERSOR == VERSOR_TEXTURE
    valid = versorOfTexture(data, q, next);
#elif VERSOR == VERSOR_VALUE
    // The map's value divided by its length.
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
                           __global const uint* places, __global const float* values) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Data data = {numbers, integers, places, values};
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

/// Whether F is not known at an end of an edge, but only its sign.
bool isSignAlone(double field) { return !(field < STORED_FIELD_LIMIT && field > -STORED_FIELD_LIMIT); }

/// Sets *field to F at a point, rounded as a stored value would be. Returns whether it is valid.
bool storedFieldAt(Data data, const double* at, double* field) {
  if (!fieldAt(data, at, field)) return false;
  float stored = (float)*field;
  if (stored == 0 && *field < 0) stored = -LEAST_STORED;
  *field = (double)stored;
  return true;
}

/// Finds where F changes its sign on an edge, in voxels from its beginning, or -1 where the processor has to look at it:
/// FieldEvaluator::findCrossings().
/// @param begin   its beginning
/// @param index   of the beginning along the axis
/// @param from    F at its beginning, as in CrossedEdge
/// @param width   of a bracket that is narrow enough
/// @param widest  that a bracket may be after the first round
double searchEdge(Data data, const double* begin, int axis, double index, double from, double to,
                  __global const double* lattice, double width, double widest) {
  double at[3] = {begin[0], begin[1], begin[2]};
  double low = 0, high = 1, field;
  if (isSignAlone(from) && !storedFieldAt(data, at, &from)) return -1;
  if (isSignAlone(to)) {
    at[axis] = coordinateAt(lattice, index + 1, axis);
    if (!storedFieldAt(data, at, &to)) return -1;
  }
  double atLow = damped(from), atHigh = damped(to);
  for (; high - low > width; widest = widest / 2) {
    const double next = nextPoint(low, high, atLow, atHigh, widest);
    at[axis] = coordinateAt(lattice, index + next, axis);
    if (!fieldAt(data, at, &field)) return -1;
    if ((field < 0) == (atLow < 0)) {
      low = next;
      atLow = damped(field);
    } else {
      high = next;
      atHigh = damped(field);
    }
  }
  return low + (high - low) / 2;
}

/// Searches @a count edges.
/// @param edges  six numbers of each: its beginning, the index there, F at its ends
__kernel void searchEdges(__global const double* edges, __global const int* axes, __global double* found, uint count,
                          __global const Real* numbers, __global const int* integers,
                          __global const uint* places, __global const float* values,
                          __global const double* lattice, double width, double widest) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Data data = {numbers, integers, places, values};
  __global const double* edge = edges + 6 * (size_t)i;
  const double begin[3] = {edge[0], edge[1], edge[2]};
  found[i] = searchEdge(data, begin, axes[i], edge[3], edge[4], edge[5], lattice, width, widest);
}

/// Searches @a count edges between nodes of the lattice.
/// @param edges  four numbers of each: its first node, and the axis
/// @param ends   F at the ends of each; of no edge if only the signs are known
/// @param known  whether F is known at any end
__kernel void searchNodeEdges(__global const int* edges, __global const float* ends, __global double* found, uint count,
                              __global const Real* numbers, __global const int* integers,
                              __global const uint* places, __global const float* values,
                              __global const double* lattice, double width, double widest, int known) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Data data = {numbers, integers, places, values};
  __global const int* edge = edges + 4 * (size_t)i;
  double begin[3];
  for (int axis = 0; axis < 3; ++axis) begin[axis] = coordinateAt(lattice, (double)edge[axis], axis);
  const double from = known ? (double)ends[2 * (size_t)i] : (double)STORED_FIELD_LIMIT;
  const double to = known ? (double)ends[2 * (size_t)i + 1] : (double)STORED_FIELD_LIMIT;
  found[i] = searchEdge(data, begin, edge[3], (double)edge[edge[3]], from, to, lattice, width, widest);
}

/// Evaluates the signs of F at the nodes of blocks, for groups of the 64 nodes of one x.
/// @param blocks   four numbers of each: its first node, and SignBlock::wanted
/// @param inside   receives in bit z of byte 64 i + 8 x + y whether F < 0 at that node of block i
/// @param unusual  receives the same for nodes that the processor has to look at
/// @param count    of all nodes
__kernel __attribute__((reqd_work_group_size(64, 1, 1)))
void findSigns(__global const int* blocks, __global uchar* inside, __global uchar* unusual, uint count,
               __global const Real* numbers, __global const int* integers,
               __global const uint* places, __global const float* values,
               __global const double* lattice) {
  __local uchar flags[64];
  const size_t i = get_global_id(0);
  const uint own = (uint)get_local_id(0);
  const int node = (int)(i & 511), x = node >> 6, y = node >> 3 & 7, z = node & 7;
  uchar flag = 0;
  if (i < count) {
    __global const int* block = blocks + 4 * (i >> 9);
    if (block[3] >> ((x >> 2) * 4 + (y >> 2) * 2 + (z >> 2)) & 1) {
      const Data data = {numbers, integers, places, values};
      const double at[3] = {coordinateAt(lattice, (double)block[0] + (double)x, 0),
                            coordinateAt(lattice, (double)block[1] + (double)y, 1),
                            coordinateAt(lattice, (double)block[2] + (double)z, 2)};
      double field;
      flag = fieldAt(data, at, &field) ? (field < 0 ? 1 : 0) : 2;
    }
  }
  flags[own] = flag;
  barrier(CLK_LOCAL_MEM_FENCE);
  // Each of the first eight items packs a row along z.
  if (own >= 8 || i >= count) return;
  uint rowInside = 0, rowUnusual = 0;
  for (uint k = 0; k < 8; ++k) {
    const uint of = flags[8 * own + k];
    rowInside |= (of & 1) << k;
    rowUnusual |= (of >> 1) << k;
  }
  const size_t row = ((i - own) >> 3) + own;
  inside[row] = (uchar)rowInside;
  unusual[row] = (uchar)rowUnusual;
}
#endif

/// Computes numbers that reveal arithmetic other than that of IEEE 754: fused operations, flushed denormal numbers,
/// inexact quotients and roots.
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
