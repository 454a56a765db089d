// SPDX-License-Identifier: Apache-2.0
// Rays that are sampled until they meet the set, and points around points, in OpenCL C. orbit.cl comes before it, with
// fieldAt(). julia/ray_march.h says what a ray is. It is in doubles for F in floats, too.

#if SEARCHES
/// A march: `numbers` are its eye, alpha, epsilon, the corner of the cubes, their side and its inverse; `integers` are
/// delta, how many members and bisections there are, and the counts of cubes.
typedef struct {
  __global const double* numbers;
  __global const int* integers;
  __global const double* members;
  __global const uint* occupied;
} March;

double stepAt(March march, double t) {
  const int delta = march.integers[0];
  const double power = delta == 1 ? t : delta == 0 ? 1 : t * t;
  const double length = march.numbers[3] * power;
  return length < march.numbers[4] ? march.numbers[4] : length;
}

/// Sets *before and *t to the last member of the sequence before a place, and to the next one.
void reachPlace(March march, double place, double* before, double* t) {
  int low = 0, high = march.integers[1];
  // Number `low` is below the place, and number `high`, if there is one, is not.
  while (high - low > 1) {
    const int middle = low + (high - low) / 2;
    if (march.members[middle] < place)
      low = middle;
    else
      high = middle;
  }
  *before = march.members[low];
  *t = *before + stepAt(march, *before);
  while (*t < place) {
    *before = *t;
    *t = *t + stepAt(march, *t);
  }
}

void placeAlong(March march, const double* direction, double t, double* at) {
  for (int k = 0; k < 3; ++k) at[k] = march.numbers[k] + t * direction[k];
}

/// Whether a sample is in a cube where F is not proved to be at least 0; otherwise sets *end to a distance beyond the
/// cube.
bool isOccupied(March march, const double* direction, double t, double* end) {
  double at[3];
  int cell[3];
  placeAlong(march, direction, t, at);
  for (int k = 0; k < 3; ++k) {
    at[k] = (at[k] - march.numbers[5 + k]) * march.numbers[9];
    const double low = floor(at[k]);
    if (!(low >= 0 && low < (double)march.integers[3 + k])) return true;
    cell[k] = (int)low;
  }
  const uint number = ((uint)cell[0] * (uint)march.integers[4] + (uint)cell[1]) * (uint)march.integers[5] + (uint)cell[2];
  if (march.occupied[number >> 5] >> (number & 31) & 1) return true;
  double out = INFINITY;
  for (int k = 0; k < 3; ++k) {
    if (direction[k] == 0) continue;
    const double face = (double)(direction[k] > 0 ? cell[k] + 1 : cell[k]);
    const double here = t + (face - at[k]) * march.numbers[8] / direction[k];
    out = here < out ? here : out;
  }
  const double more = nextafter(t, (double)INFINITY);
  *end = out < more ? more : out;
  return false;
}

#define RAY_MISSED 0
#define RAY_MET 1
#define RAY_LEFT 2
#define RAY_GOES_ON 3

/// Moves to the first sample of a ray that has to be evaluated. Returns false if there is none.
bool toSample(March march, const double* direction, double end, double* before, double* t) {
  while (*t <= end) {
    double place = *t, beyond, reached, next;
    while (!isOccupied(march, direction, place, &beyond)) {
      place = beyond;
      if (place > end) return false;
    }
    if (place == *t) return true;
    reachPlace(march, place, &reached, &next);
    *before = reached > *t ? reached : *t;
    *t = next;
  }
  return false;
}

/// As fieldAt(), but of a point that has escaped only the sign is right.
bool signAt(Data data, const double* at, double* field) {
  __global const Real* numbers = data.numbers;
  const Real x = (Real)at[0], y = (Real)at[1], z = (Real)at[2], slice = numbers[SLICE];
  if (numbers[LOG_ESCAPE] >= numbers[LEVEL] &&
      x * x + y * y + z * z + slice * slice > numbers[NEAR_SQUARED] * BEYOND_NEAR) {
    *field = FIELD_LIMIT;
    return true;
  }
  return fieldAt(data, at, field);
}

/// Follows @a count rays, each up to so many samples.
/// @param rays      six numbers of each, as in MarchedRay
/// @param brackets  receives `outside` and `inside` of each
/// @param ends      receives a RayEnd, or RAY_GOES_ON, and the number of samples of each
__kernel void followRays(__global const double* rays, __global double* brackets, __global int* ends, uint count,
                         __global const Real* numbers, __global const int* integers,
                         __global const uint* places, __global const float* values,
                         __global const double* marchNumbers, __global const int* marchIntegers,
                         __global const double* members, __global const uint* occupied, int skips, int most) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Data data = {numbers, integers, places, values};
  const March march = {marchNumbers, marchIntegers, members, occupied};
  __global const double* ray = rays + 6 * (size_t)i;
  const double direction[3] = {ray[0], ray[1], ray[2]};
  double before = ray[3], t = ray[4], at[3], field, reached;
  const double end = ray[5];
  int kind = RAY_MISSED, samples = 0;
  while (skips ? toSample(march, direction, end, &before, &t) : t <= end) {
    if (samples == most) {
      kind = RAY_GOES_ON;
      break;
    }
    ++samples;
    placeAlong(march, direction, t, at);
    if (!signAt(data, at, &field)) {
      kind = RAY_LEFT;
      break;
    }
    if (field < 0) {
      kind = RAY_MET;
      break;
    }
    if (before == t) {
      reachPlace(march, nextafter(t, (double)INFINITY), &reached, &field);
      before = reached > t ? reached : t;
      t = field;
    } else {
      before = t;
      t = t + stepAt(march, t);
    }
  }
  if (kind == RAY_MET && before < t) {
    double outside = before, inside = t;
    int left = march.integers[2];
    for (; left > 0; --left) {
      const double middle = 0.5 * (outside + inside);
      placeAlong(march, direction, middle, at);
      if (!signAt(data, at, &field)) break;
      if (field < 0)
        inside = middle;
      else
        outside = middle;
    }
    // The processor repeats a bisection that it has to help with.
    kind = left > 0 ? RAY_LEFT : RAY_MET;
    if (left == 0) {
      before = outside;
      t = inside;
    }
  }
  brackets[2 * (size_t)i] = before;
  brackets[2 * (size_t)i + 1] = t;
  ends[2 * (size_t)i] = kind;
  ends[2 * (size_t)i + 1] = samples;
}

/// Follows the orbits of @a count points, which lie around others in the same directions.
/// @param centres     four numbers of each centre: its coordinates, and the distance of the points from it
/// @param directions  three numbers of each of @a each directions
__kernel void followAround(__global const double* centres, __global Real* ends, __global int* steps, uint count,
                           __global const Real* numbers, __global const int* integers,
                           __global const uint* places, __global const float* values,
                           __global const double* directions, uint each) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const Data data = {numbers, integers, places, values};
  __global const double* centre = centres + 4 * (size_t)(i / each);
  __global const double* direction = directions + 3 * (size_t)(i % each);
  double at[3];
  for (int k = 0; k < 3; ++k) at[k] = centre[k] + centre[3] * direction[k];
  Real end;
  steps[i] = followOrbit(data, (Real)at[0], (Real)at[1], (Real)at[2], &end);
  ends[i] = end;
}
#endif
