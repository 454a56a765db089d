// SPDX-License-Identifier: Apache-2.0
// The shaders: F of each map in 32-bit floats, and the rays through it. The rules are those of libjulia's kernels and
// of the field renderer (vdbtools/render/field_render.h), so that the preview and the exact picture agree.
import { pairInGlsl } from "./expression.js";

export const VERTEX_SHADER = `#version 300 es
in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }
`;

const HEADER = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler3D;

uniform int iterationLimit;
uniform float escapeRadius, logEscape, level, logTrap, slice;
uniform int dropped;  // the component that holds the slice: 1, 2 or 3

// Results of the last orbit besides its F.
int orbitSteps;      // number of steps
vec4 orbitVersor;    // the direction of the first step, if requested
float orbitNearest;  // the smallest l of the iterates

vec4 embedded(vec3 x) {
  return dropped == 3 ? vec4(x, slice) : dropped == 2 ? vec4(x.xy, slice, x.z) : vec4(x.x, slice, x.yz);
}
vec3 kept(vec4 q) { return dropped == 3 ? q.xyz : dropped == 2 ? q.xyw : q.xzw; }

float logNorm(vec4 q) { return 0.5 * log(max(dot(q, q), 1e-38)); }
float square(float x) { return x * x; }

// Elementary functions of known precision: those of GLSL may be off by thousands of units in the last place.
// The angle of (a, b) with b >= 0, in quadrants: 0 to 2.
float quadrantsOf(float a, float b) {
  float x = abs(a), most = max(x, b);
  if (!(most > 0.0)) return 0.0;
  float t = min(x, b) / most, s = t * t;
  float p = t * (1.0 + s * (-0.3333314528 + s * (0.1999355085 + s * (-0.1420889944 + s * (0.1065626393 +
            s * (-0.0752896400 + s * (0.0429096138 + s * (-0.0161657367 + s * 0.0028662257))))))));
  float angle = p * 0.63661977236758134;
  if (b > x) angle = 1.0 - angle;
  return a < 0.0 ? 2.0 - angle : angle;
}
// The cosine and sine of an angle in quadrants.
vec2 turned(float quadrants) {
  float whole = floor(quadrants + 0.5), r = (quadrants - whole) * 1.5707963267948966, s = r * r;
  float sine = r * (1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s / 362880.0))));
  float cosine = 1.0 + s * (-0.5 + s * (1.0 / 24.0 + s * (-1.0 / 720.0 + s * (1.0 / 40320.0))));
  float quarter = whole - 4.0 * floor(0.25 * whole);
  vec2 result = quarter == 1.0 || quarter == 3.0 ? vec2(sine, cosine) : vec2(cosine, sine);
  return vec2(quarter == 1.0 || quarter == 2.0 ? -result.x : result.x, quarter >= 2.0 ? -result.y : result.y);
}
float cosineOf(float radians) { return turned(radians * 0.63661977236758134).x; }
float sineOf(float radians) { return turned(radians * 0.63661977236758134).y; }

// (a + b i)^n.
vec2 complexPower(vec2 z, int n) {
  vec2 result = vec2(1.0, 0.0);
  for (int rest = n; rest > 0; rest >>= 1) {
    if ((rest & 1) == 1) result = vec2(result.x * z.x - result.y * z.y, result.x * z.y + result.y * z.x);
    if (rest > 1) z = vec2(z.x * z.x - z.y * z.y, 2.0 * z.x * z.y);
  }
  return result;
}
// The same for a unit number and a real power, with the angle from -2 to 2 quadrants.
vec2 unitPower(vec2 z, float p) {
  float quadrants = quadrantsOf(z.x, abs(z.y));
  return turned(p * (z.y < 0.0 ? -quadrants : quadrants));
}
`;

const PRODUCT = `
vec4 product(vec4 p, vec4 q) {
  return vec4(p.x * q.x - dot(p.yzw, q.yzw), p.x * q.yzw + q.x * p.yzw + cross(p.yzw, q.yzw));
}
`;

const FACTORS = `
uniform sampler2D factors;  // two texels per factor: the root; its power and whether that is whole
uniform int factorCount;
uniform float logScale;

// The factor (q - t)^p over its length; squared is |q - t|^2.
vec4 factorOf(vec4 d, float squared, float power, bool whole) {
  float inverse = inversesqrt(squared);
  d *= inverse;
  float s = dot(d.yzw, d.yzw);
  if (whole) {
    // In the plane of 1 and v, the imaginary part: (R + S v)^2 = R^2 - S^2 s + 2 R S v.
    float R = 1.0, S = 0.0, a = d.x, b = 1.0;
    for (int rest = int(abs(power)); rest > 0; rest >>= 1) {
      if ((rest & 1) == 1) {
        float real = R * a - S * b * s;
        S = R * b + S * a;
        R = real;
      }
      float real = a * a - b * b * s;
      b = 2.0 * a * b;
      a = real;
    }
    return vec4(R, (power < 0.0 ? -S : S) * d.yzw);
  }
  float imaginary = sqrt(s);
  vec2 turn = turned(power * quadrantsOf(d.x, imaginary));
  // A negative real has no direction of its own and uses i.
  return imaginary > 1e-15 ? vec4(turn.x, (turn.y / imaginary) * d.yzw) : vec4(turn.x, turn.y, 0.0, 0.0);
}

// ln|p(q)| and p/|p|. A root that is hit counts as 1.
void evaluateFactors(vec4 q, bool wantModulus, bool wantVersor, out float l, out vec4 u) {
  l = logScale;
  u = vec4(1.0, 0.0, 0.0, 0.0);
  for (int i = 0; i < factorCount; ++i) {
    ivec2 at = ivec2(2 * (i & 511), i >> 9);
    vec4 d = q - texelFetch(factors, at, 0);
    vec2 power = texelFetch(factors, at + ivec2(1, 0), 0).xy;
    float squared = dot(d, d);
    if (wantModulus) l += 0.5 * power.x * log(max(squared, 1e-37));
    if (wantVersor && squared > 1e-30) u = product(u, factorOf(d, squared, power.x, power.y > 0.5));
    if ((i & 15) == 15) u = normalize(u);
  }
  u = normalize(u);
}
`;

const EXPONENT = `
uniform sampler3D exponent;
uniform mat3 toNode;
uniform vec3 nodeOffset, nodeCount, originShift;
uniform vec2 knee;  // its position, and by how much the slope below it is larger

float exponentAt(vec3 x) {
  vec3 node = clamp(toNode * (x + originShift) + nodeOffset, vec3(0.0), nodeCount - 1.0);
  float v = textureLod(exponent, (node + 0.5) / nodeCount, 0.0).r;
  return v + knee.y * min(v - knee.x, 0.0);
}
`;

const WAVE_FACTORS = `
uniform sampler2D waves;  // four texels per wave: frequency, cosine, sine, and the power after the last wave of a factor
uniform int waveCount;

vec4 unitOf(vec4 g) {
  float squared = dot(g, g);
  return squared > 1e-30 ? g * inversesqrt(squared) : vec4(1.0, 0.0, 0.0, 0.0);
}
`;

const WAVES = `
uniform vec4 waveOrigin;
uniform float waveScale;
uniform sampler3D octave;
uniform mat3 toOctaveNode;
uniform vec3 octaveOffset, octaveCount;

vec4 versor_(vec4 q, vec4 unused) {
  vec3 node = clamp(toOctaveNode * (kept(q) + originShift) + octaveOffset, vec3(0.0), octaveCount - 1.0);
  float o = textureLod(octave, (node + 0.5) / octaveCount, 0.0).r, k = floor(o), f = o - k;
  vec4 p = (q - waveOrigin) * (exp2(k) * waveScale);
  vec4 coarse = vec4(1.0, 0.0, 0.0, 0.0), fine = coarse, sum = vec4(0.0), fineSum = vec4(0.0);
  for (int i = 0; i < waveCount; ++i) {
    vec4 cosines = texelFetch(waves, ivec2(4 * i + 1, 0), 0), sines = texelFetch(waves, ivec2(4 * i + 2, 0), 0);
    float turns = dot(texelFetch(waves, ivec2(4 * i, 0), 0), p);
    vec2 at = turned(4.0 * (turns - round(turns)));  // cosine, sine
    sum += cosines * at.x + sines * at.y;
    fineSum += cosines * (1.0 - 2.0 * at.y * at.y) + sines * (2.0 * at.x * at.y);
    int power = int(texelFetch(waves, ivec2(4 * i + 3, 0), 0).x);
    if (power == 0) continue;
    vec4 g = unitOf(sum), h = unitOf(fineSum);
    if (power < 0) {
      g.yzw = -g.yzw;
      h.yzw = -h.yzw;
    }
    for (int times = 0; times < abs(power); ++times) {
      coarse = product(coarse, g);
      fine = product(fine, h);
    }
    sum = vec4(0.0);
    fineSum = vec4(0.0);
  }
  return unitOf(mix(coarse, fine, f * f * (3.0 - 2.0 * f)));
}
`;

// Waves whose phases are read from fields: see julia/grain_versor.h.
const GRAIN = `
uniform sampler3D phases;  // cosine and sine of the phase along the grain, and of the one across it
uniform sampler3D depths;  // from the surface, in wavelengths
uniform mat3 toGrainNode;
uniform vec3 grainOffset, grainCount;

// The angle of a cosine and a sine, from -2 to 2 quadrants.
float phaseOf(vec2 z) {
  float quadrants = quadrantsOf(z.x, abs(z.y));
  return z.y < 0.0 ? -quadrants : quadrants;
}
// How much a phase counts, from 0 to 1.
float certaintyOf(vec2 z) {
  float t = min(2.0 * dot(z, z), 1.0);
  return t * t * (3.0 - 2.0 * t);
}

vec4 versor_(vec4 q, vec4 unused) {
  vec3 node = clamp(toGrainNode * (kept(q) + originShift) + grainOffset, vec3(0.0), grainCount - 1.0);
  vec3 place = (node + 0.5) / grainCount;
  vec4 read = textureLod(phases, place, 0.0);
  vec3 angles = vec3(phaseOf(read.xy), phaseOf(read.zw), 4.0 * textureLod(depths, place, 0.0).r);
  vec4 product_ = vec4(1.0, 0.0, 0.0, 0.0), sum = vec4(0.0);
  for (int i = 0; i < waveCount; ++i) {
    vec2 at = turned(dot(texelFetch(waves, ivec2(4 * i, 0), 0).xyz, angles));  // cosine, sine
    sum += texelFetch(waves, ivec2(4 * i + 1, 0), 0) * at.x + texelFetch(waves, ivec2(4 * i + 2, 0), 0) * at.y;
    int power = int(texelFetch(waves, ivec2(4 * i + 3, 0), 0).x);
    if (power == 0) continue;
    vec4 g = unitOf(sum);
    if (power < 0) g.yzw = -g.yzw;
    for (int times = 0; times < abs(power); ++times) product_ = product(product_, g);
    sum = vec4(0.0);
  }
  return unitOf(mix(vec4(1.0, 0.0, 0.0, 0.0), product_, certaintyOf(read.xy) * certaintyOf(read.zw)));
}
`;

// A step computes ln|f(q)| first, because the last step needs no direction.
const LOG_POLAR_ORBIT = `
float follow(vec3 x, bool wantVersor) {
  vec4 q = embedded(x);
  orbitSteps = 0;
  orbitNearest = 1e30;
  if (dot(q, q) >= square(escapeRadius)) return max(logNorm(q), logEscape) - level;
  float l = 0.0;
  for (int i = 1; i <= iterationLimit; ++i) {
    vec4 u;
    bool last = i == iterationLimit;
    step_(q, !last || (wantVersor && i == 1), l, u);
    orbitSteps = i;
    orbitNearest = min(orbitNearest, l);
    bool ends = last || l >= logEscape || l <= logTrap;
    if (!ends || (wantVersor && i == 1)) {
      vec4 towards = versor_(q, u);
      if (i == 1) orbitVersor = towards;
      q = exp(min(l, 40.0)) * towards;
    }
    if (ends) break;
  }
  return l - level;
}
`;

const SHAPE_STEP = `
// The versor is computed by versor_(), which is called only if the orbit continues.
void step_(vec4 q, bool wantVersor, out float l, out vec4 u) { l = exponentAt(kept(q)); u = vec4(0.0); }
`;

const ROOTS_VERSOR = `
vec4 versor_(vec4 q, vec4 u) {
  float l;
  evaluateFactors(q, false, true, l, u);
  return u;
}
`;

const RATIONAL_STEP = `
void step_(vec4 q, bool wantVersor, out float l, out vec4 u) { evaluateFactors(q, true, wantVersor, l, u); }
vec4 versor_(vec4 q, vec4 u) { return u; }
`;

const UNDEFINED_ITERATE = `
const float UNDEFINED = 1e18;  // stands for a component that is not defined; such an iterate has escaped
`;

const CARTESIAN_ORBIT = `
float follow(vec3 x, bool wantVersor) {
  vec4 q = embedded(x);
  orbitSteps = 0;
  orbitNearest = 1e30;
  if (dot(q, q) >= square(escapeRadius)) return max(logNorm(q), logEscape) - level;
  if (wantVersor) {
    vec4 towards = direction_(q);
    orbitVersor = dot(towards, towards) > 1e-37 ? normalize(towards) : vec4(1.0, 0.0, 0.0, 0.0);
  }
  vec4 start = q;
  float l = 0.0;
  for (int i = 1; i <= iterationLimit; ++i) {
    q = i == 1 ? begin_(q) : step_(q, start);
    float squared = dot(q, q);
    l = squared < 1e37 ? 0.5 * log(max(squared, 1e-38)) : 43.0;
    orbitSteps = i;
    orbitNearest = min(orbitNearest, l);
    if (l >= logEscape || l <= logTrap) break;
  }
  return l - level;
}
`;

const QUADRATIC_STEP = `
uniform vec4 constant;
uniform bool mandelbrot;

vec4 squared_(vec4 q) { return vec4(q.x * q.x - dot(q.yzw, q.yzw), 2.0 * q.x * q.yzw); }
vec4 begin_(vec4 q) { return squared_(q) + (mandelbrot ? q : constant); }
vec4 step_(vec4 q, vec4 start) { return squared_(q) + (mandelbrot ? start : constant); }
vec4 direction_(vec4 q) { return begin_(q); }
`;

const MANDELBULB_STEP = `
uniform vec4 constant;
uniform bool mandelbrot, fromPole;
uniform float power;
uniform int wholePower;  // 0: by angles

vec4 powered(vec4 q) {
  float flat_ = length(q.xy);
  vec2 around = flat_ > 1e-18 ? q.xy / flat_ : vec2(1.0, 0.0);
  vec2 above = fromPole ? vec2(q.z, flat_) : vec2(flat_, q.z);
  if (wholePower != 0) {
    around = complexPower(around, wholePower);
    above = complexPower(above, wholePower);
  } else {
    float r = length(above);
    if (!(r > 1e-18)) return power > 0.0 ? vec4(0.0) : power < 0.0 ? vec4(UNDEFINED) : vec4(1.0, 0.0, 0.0, 0.0);
    float l = power * log(r);
    if (!(l < 40.0)) return vec4(UNDEFINED);
    around = unitPower(around, power);
    above = exp(l) * unitPower(above / r, power);
  }
  if (fromPole) above = above.yx;
  return vec4(above.x * around, above.y, 0.0);
}
vec4 begin_(vec4 q) { return powered(q) + (mandelbrot ? q : constant); }
vec4 step_(vec4 q, vec4 start) { return powered(q) + (mandelbrot ? start : constant); }
vec4 direction_(vec4 q) { return powered(q); }
`;

const PAIR_A = (sign) => `
vec3 crossed(vec3 p) {
  float level_ = dot(p.xy, p.xy), cosine = level_ - p.z * p.z;
  float last = ${sign}.0 * 2.0 * p.z * sqrt(level_);
  if (!(level_ > 1e-36)) return vec3(cosine, 0.0, last);
  float by = cosine / level_, across = p.x * p.x - p.y * p.y;
  return vec3(across != 0.0 ? across * by : UNDEFINED, 2.0 * p.x * p.y * by, last);
}
vec3 secondOf(vec3 p) {
  float level_ = dot(p.xy, p.xy), r = level_ + p.z * p.z;
  float cos2phi = level_ > 1e-36 ? (p.x * p.x - p.y * p.y) / level_ : 1.0;
  float cos2theta = r > 1e-36 ? (level_ - p.z * p.z) / r : 1.0;
  float sin2theta = r > 1e-36 ? 2.0 * sqrt(level_) * p.z / r : 0.0;
  return vec3(cos2phi != 0.0 ? ${-sign}.0 * sin2theta / cos2phi : UNDEFINED, 0.0, cos2theta);
}
`;

const COSINES = "vec3(cosineOf(p.x), cosineOf(p.y), cosineOf(p.z))";
const PAIRS = {
  "A": PAIR_A(1),
  "A'": PAIR_A(-1),
  "B": `
vec3 secondOf(vec3 p) { return ${COSINES}; }
vec3 crossed(vec3 p) { return cross(vec3(1.0), secondOf(p)); }
`,
  "C": `
vec3 secondOf(vec3 p) { return ${COSINES}; }
vec3 crossed(vec3 p) { return cross(p * p, secondOf(p)); }
`,
  "D": `
vec3 secondOf(vec3 p) { return vec3(0.0, 0.0, 1.0); }
vec3 crossed(vec3 p) {
  float level_ = dot(p.xy, p.xy), all = dot(p, p);
  if (!(level_ > 1e-36)) return vec3(all, 0.0, 0.0);
  return (all / level_) * vec3(p.x * p.x - p.y * p.y, 2.0 * p.x * p.y, 0.0);
}
`,
  "E": `
vec3 secondOf(vec3 p) { return vec3(1.0, cosineOf(p.z), 1.0); }
vec3 crossed(vec3 p) { return cross(vec3(p.x * p.x * p.y, p.yz * p.yz), secondOf(p)); }
`,
};

const userPair = (scene) => `
${pairInGlsl(scene.f, scene.g)}
vec3 secondOf(vec3 p) { return userSecond(p); }
vec3 crossed(vec3 p) {
  vec3 result = cross(userFirst(p), userSecond(p));
  return dot(result, result) < 1e36 ? result : vec3(UNDEFINED);
}
`;

// Schemes (3), (4) and (5) of cross_map.h.
const crossStep = (scene) => `
uniform vec4 constant;
${scene.pair === "user" ? userPair(scene) : PAIRS[scene.pair]}
vec4 begin_(vec4 q) {
  return vec4(crossed(q.xyz), 0.0)${scene.scheme === 4 ? " + q" : scene.scheme === 5 ? " + constant" : ""};
}
vec4 step_(vec4 q, vec4 start) {
  return ${scene.scheme === 3 ? "vec4(cross(q.xyz, secondOf(start.xyz)), 0.0)"
    : `vec4(crossed(q.xyz), 0.0) + ${scene.scheme === 4 ? "start" : "constant"}`};
}
vec4 direction_(vec4 q) { return vec4(crossed(q.xyz), 0.0); }
`;

const RAYS = `
uniform vec3 eye, right, up, forward;
uniform float tangent, aspect;
uniform vec2 pixels, jitter;  // size of the picture; where in a pixel the ray goes, 0 to 1
uniform vec3 regionMin, regionMax;
uniform vec4 clip;  // points with dot(clip.xyz, x) > clip.w are cut away; 0: nothing
uniform float stepAlpha, stepLeast, stepFirst;
uniform int axisCount;  // number of axes of the differences for normals: 13, or 3 for a coarse picture
uniform int colourBy;               // 0 direction, 1 versor, 2 iterations, 3 trap, 4 clay, 5 depth
uniform sampler2D gradient;
uniform vec2 gradientRange;  // the numbers at the two ends of the gradient
// The light: see vdbtools/render/shading.h. All directions have length 1.
uniform vec3 sky, keyLight, rim;
uniform float skyStrength, gain;
uniform vec3 albedoOf, gloss;  // those of the material
uniform float sharpness;
uniform bool mirrors;
uniform int openRays, openPlaces;  // number of rays towards the sky, and of samples along each
uniform float keyGrowth;  // growth of the steps towards the key light
uniform vec3 lightJitter;  // differs between the pictures of a mean, each component 0 to 1
uniform vec3 middle;  // centre of the ball around the set
uniform float radius;
uniform bool ground;
uniform float floorHeight;          // along the sky
uniform int backdrop;               // 0 neutral, 1 plain, 2 none
uniform vec3 plain;
uniform sampler2D before;           // the mean of the pictures so far
uniform float share;  // weight of this picture in the new mean

// For each cube of a lattice, its distance, in cubes, from the nearest cube in which the set may lie.
uniform sampler3D emptiness;
uniform vec3 cubeOrigin, cubeSide;
uniform ivec3 cubeCount;            // 0: there are none

out vec4 result;

const int MARCH = 0, BISECT = 1, AROUND = 2, COLOUR = 3, OPEN = 4, KEY = 5, DONE = 6;
const float SATURATION = 0.85, BOUNCE = 0.25, KEY_RADIUS = 0.07, FLOOR_ENDS = 6.0, LEAVES = 2.25;
const vec3 KEY_COLOUR = vec3(1.22, 1.12, 0.97), SKY_COLOUR = vec3(0.44, 0.50, 0.60), FLOOR_COLOUR = vec3(0.10, 0.08, 0.07),
  RIM_COLOUR = vec3(0.62, 0.70, 0.85);
const int STEPS = 6000, BISECTIONS = 12;

float stepAt(float t) { return max(stepAlpha * t, stepLeast); }

// The samples of all rays belong to one sequence of distances that begins at stepFirst, as in the exact picture.
// Returns its first member that is not below a distance.
float onSequence(float t) {
  if (stepAlpha * stepFirst < stepLeast) return t;
  float growth = log(1.0 + stepAlpha);
  return stepFirst * exp(ceil(log(t / stepFirst) / growth - 1e-3) * growth);
}

vec3 linearOf(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), vec3(greaterThan(c, vec3(0.04045))));
}

// The distance at which a ray leaves the empty cubes about its position; t itself where the set may be.
float afterEmptiness(vec3 direction, vec3 inverse, float t) {
  vec3 place = (eye + t * direction - cubeOrigin) / cubeSide;
  ivec3 cube = clamp(ivec3(floor(place)), ivec3(0), cubeCount - 1);
  float reach = floor(texelFetch(emptiness, cube, 0).r * 255.0 + 0.5);
  if (reach < 0.5) return t;
  vec3 low = vec3(cube) - (reach - 1.0), high = vec3(cube) + reach;
  vec3 faces = mix(low, high, vec3(greaterThan(direction, vec3(0.0))));
  vec3 distances = (faces - place) * cubeSide * inverse;
  return t + max(min(distances.x, min(distances.y, distances.z)), 0.5 * stepAt(t)) + 1e-6;
}

vec3 backgroundAt(vec2 uv) {
  return vec3(mix(0.64, 0.86, 0.5 * (uv.y + 1.0)) - 0.05 * dot(uv, uv));
}

vec3 rampAt(float number) {
  float v = (number - gradientRange.x) / (gradientRange.y - gradientRange.x);
  return linearOf(textureLod(gradient, vec2((clamp(v, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5), 0.0).rgb);
}

// The light from a direction, except the key light.
vec3 environment(vec3 towards) {
  float height = 0.5 * (1.0 + dot(towards, sky)), edge = square(max(0.0, dot(towards, rim)));
  return skyStrength * (FLOOR_COLOUR + height * (SKY_COLOUR - FLOOR_COLOUR) + edge * edge * RIM_COLOUR);
}
// The mean of that light over the directions about a normal, weighted by their cosines. For the rim light, the fourth
// power of a cosine, it is exact where the normal points along, across or against it.
vec3 gathered(vec3 n) {
  float height = 0.5 + dot(n, sky) / 3.0;
  return skyStrength * (FLOOR_COLOUR + height * (SKY_COLOUR - FLOOR_COLOUR) +
    pow(max(0.0, 0.5 + 0.5 * dot(n, rim)), 2.415) / 3.0 * RIM_COLOUR);
}
float brightness(vec3 c) { return (c.r + c.g + c.b) / 3.0; }

mat3 frameOf(vec3 n) {
  float side = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (side + n.z), b = n.x * n.y * a;
  return mat3(vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x), vec3(b, side + n.y * n.y * a, -n.y), n);
}

// Direction number i of openRays about a normal, with cosine density.
vec3 openDirection(mat3 about, int i, float grain) {
  float area = (float(i) + lightJitter.z) / float(openRays), angle = 6.2831853 * fract(0.618034 * float(i) + lightJitter.x + grain);
  return about * vec3(sqrt(area) * vec2(cos(angle), sin(angle)), sqrt(1.0 - area));
}

// Whether the set may be at a point: in the region, on the remaining side of the cut, and not in an empty cube.
bool mayBe(vec3 x) {
  if (any(lessThan(x, regionMin)) || any(greaterThan(x, regionMax)) || dot(clip.xyz, x) > clip.w) return false;
  if (cubeCount.x == 0) return true;
  ivec3 cube = clamp(ivec3(floor((x - cubeOrigin) / cubeSide)), ivec3(0), cubeCount - 1);
  return texelFetch(emptiness, cube, 0).r < 0.5 / 255.0;
}

void main() {
  vec2 uv = 2.0 * (gl_FragCoord.xy - 0.5 + jitter) / pixels - 1.0;
  vec3 direction = normalize(forward + tangent * (uv.x * aspect * right + uv.y * up));
  // No component may be 0, because it is a divisor.
  direction = mix(direction, vec3(1e-9), vec3(lessThan(abs(direction), vec3(1e-9))));
  vec3 inverse = 1.0 / direction;

  vec3 toMin = (regionMin - eye) * inverse, toMax = (regionMax - eye) * inverse;
  vec3 near = min(toMin, toMax), far = max(toMin, toMax);
  float t = max(max(near.x, near.y), near.z), end = min(min(far.x, far.y), far.z);
  vec3 faceNormal = -direction;
  if (t > 0.0) faceNormal = t == near.x ? vec3(-sign(direction.x), 0, 0)
                          : t == near.y ? vec3(0, -sign(direction.y), 0) : vec3(0, 0, -sign(direction.z));
  t = max(t, 0.0);
  if (dot(clip.xyz, clip.xyz) > 0.0) {
    float along = dot(clip.xyz, direction), at = (clip.w - dot(clip.xyz, eye)) / along;
    if (along < 0.0) {
      if (at > t) { t = at; faceNormal = normalize(clip.xyz); }
    } else {
      end = min(end, at);
    }
  }

  int phase = t < end ? MARCH : DONE;
  bool entering = true, met = false, atFace = false;
  float outside = t, inside = t, width = 0.0;
  int count = 0;
  vec3 gradientOutside = vec3(0.0), gradientInside = vec3(0.0);
  int firstSteps = -1, lastSteps = 0, outsideCount = 0;
  float stepSum = 0.0;
  vec3 albedo = albedoOf, normal = -direction;

  // The rays of the light: towards the sky, the reflected one, and towards the key light.
  vec3 origin = vec3(0.0), towards = vec3(0.0);
  mat3 about = mat3(1.0);
  vec2 keyDisk = KEY_RADIUS * sqrt(lightJitter.y) * vec2(cos(6.2831853 * lightJitter.x), sin(6.2831853 * lightJitter.x));
  mat3 aboutKey = frameOf(keyLight);
  vec3 key = normalize(keyLight + aboutKey[0] * keyDisk.x + aboutKey[1] * keyDisk.y);
  float along = 0.0, firstAlong = 0.0, growth = 1.0, openLight = 0.0, allLight = 0.0, mirrorOpen = 1.0, keyOpen = 0.0, away = 0.0;
  int ray = 0, place = 0;
  // The floor is smooth: few rays in the same directions would draw copies of the surface on it.
  float grain = 0.0;
  bool isFloor = phase == DONE && ground, begins = isFloor;

  // All samples of a ray, whatever their purpose, are taken at the same place in the program. The lanes of a GPU then
  // stay together, and compilers see the orbit only once.
  for (int k = 0; k < STEPS; ++k) {
    vec3 x = vec3(0.0);
    if (phase == MARCH) {
      if (cubeCount.x > 0) {
        for (int i = 0; i < 64; ++i) {
          float next = afterEmptiness(direction, inverse, t);
          if (next == t) break;
          outside = next;
          t = onSequence(next);
          entering = false;
          if (t > end) break;
        }
      }
      if (t > end) phase = DONE;
      if (phase == DONE && ground) begins = isFloor = true;
      x = eye + t * direction;
    } else if (phase == BISECT) {
      x = eye + 0.5 * (outside + inside) * direction;
    } else if (phase == AROUND) {
      int axis = count >> 1;
      if (axisCount == 3) axis = axis == 0 ? 4 : axis == 1 ? 10 : 12;
      vec3 offset = normalize(vec3(axis / 9 - 1, axis / 3 % 3 - 1, axis % 3 - 1));
      x = eye + inside * direction + ((count & 1) == 0 ? width : -width) * offset;
    } else if (phase == COLOUR) {
      x = eye + inside * direction;
    }
    if (isFloor && begins) {
      // The floor is visible where a ray goes down and meets no surface, up to the floor's end.
      float falling = dot(direction, sky), height = floorHeight - dot(eye, sky);
      vec3 at = eye + height / falling * direction;
      away = distance(at, middle) / radius;
      if (!(falling < 0.0) || !(height < 0.0) || away > FLOOR_ENDS) {
        isFloor = begins = false;
        break;
      }
      width = stepAt(height / falling);
      normal = sky;
      origin = at;
      grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
      phase = OPEN;
    } else if (begins) {
      origin = eye + inside * direction + LEAVES * width * (normal - direction);
      phase = OPEN;
    }
    if (begins) {
      begins = false;
      about = frameOf(normal);
      firstAlong = width;
      growth = pow(max(2.0 * radius / firstAlong, 2.0), 1.0 / float(openPlaces));
      along = firstAlong * pow(growth, fract(lightJitter.y + grain));
    }
    if (phase == OPEN) {
      // Continues to the next position on one of these rays where the set may be.
      int rays = openRays + (mirrors && !isFloor ? 1 : 0);
      while (ray < rays) {
        towards = ray < openRays ? openDirection(about, ray, grain) : reflect(direction, normal);
        x = origin + along * towards;
        if (place < openPlaces && mayBe(x)) break;
        if (place < openPlaces) {
          along *= growth;
          ++place;
          continue;
        }
        if (ray < openRays) {
          float light = brightness(environment(towards));
          allLight += light;
          openLight += light;
        }
        ++ray;
        place = 0;
        along = firstAlong * pow(growth, fract(lightJitter.y + grain + 0.38 * float(ray)));
      }
      if (ray == rays) {
        phase = dot(key, normal) > 0.0 ? KEY : DONE;
        along = firstAlong * (1.0 + lightJitter.z);
        place = 0;
      }
    }
    if (phase == KEY) {
      while (along < 4.0 * radius && !mayBe(origin + along * key)) along = max(along * keyGrowth, along + 2.0 * width);
      x = origin + along * key;
      if (along >= 4.0 * radius) {
        keyOpen = 1.0;
        phase = DONE;
      }
    }
    if (phase == DONE) break;

    float f = follow(x, phase == COLOUR);

    if (phase == MARCH) {
      if (f < 0.0) {
        inside = t;
        met = true;
        atFace = entering;
        phase = entering ? AROUND : BISECT;
        count = 0;
        width = stepAt(t);
      } else {
        outside = t;
        t = entering ? onSequence(t + 1e-3 * stepAt(t)) : t + stepAt(t);
      }
      entering = false;
    } else if (phase == BISECT) {
      float middle = 0.5 * (outside + inside);
      if (f < 0.0) inside = middle; else outside = middle;
      if (++count == BISECTIONS) { phase = AROUND; count = 0; width = stepAt(inside); }
    } else if (phase == AROUND) {
      // A field that grows outwards like a distance, see field_shading.cpp: outside, it doubles for each step less.
      // Sums over opposite points are not affected by a constant, so inside and outside are summed separately.
      int axis = count >> 1;
      if (axisCount == 3) axis = axis == 0 ? 4 : axis == 1 ? 10 : 12;
      vec3 offset = normalize(vec3(axis / 9 - 1, axis / 3 % 3 - 1, axis % 3 - 1));
      if ((count & 1) == 1) offset = -offset;
      float value = 1.0 + clamp(f / logEscape, -1.0, 1.0);
      if (f < 0.0) {
        gradientInside += value * offset;
      } else {
        if (firstSteps < 0) firstSteps = orbitSteps;
        gradientOutside += value * exp2(float(clamp(firstSteps - orbitSteps, -60, 60))) * offset;
        lastSteps = max(lastSteps, orbitSteps);
        stepSum += float(orbitSteps);
        ++outsideCount;
      }
      if (++count == 2 * axisCount) {
        vec3 gradientThere = gradientOutside * exp2(float(clamp(lastSteps - firstSteps, -60, 60))) + gradientInside;
        normal = dot(gradientThere, gradientThere) > 0.0 ? normalize(gradientThere) : -direction;
        if (atFace) normal = faceNormal;
        phase = COLOUR;
        if (colourBy == 2) albedo = rampAt(stepSum / float(max(outsideCount, 1)));
        if (colourBy == 2 || colourBy == 4) begins = true;
      }
    } else if (phase == COLOUR) {
      if (colourBy == 3) albedo = rampAt(exp(orbitNearest));
      else if (colourBy == 5) albedo = rampAt(depthAt(x));
      else {
        vec3 turnedTo = colourBy == 1 ? orbitVersor.yzw : kept(orbitVersor);
        albedo = linearOf(clamp(0.5 + 0.5 * SATURATION * turnedTo, 0.0, 1.0));
      }
      begins = true;
    } else if (phase == OPEN) {
      if (f < 0.0) {
        if (ray < openRays) allLight += brightness(environment(towards));
        else mirrorOpen = 0.0;
        ++ray;
        place = 0;
        along = firstAlong * pow(growth, fract(lightJitter.y + grain + 0.38 * float(ray)));
      } else {
        along *= growth;
        ++place;
      }
    } else if (phase == KEY) {
      if (f < 0.0) phase = DONE;
      else along = max(along * keyGrowth, along + 2.0 * width);
    }
  }

  float open = allLight > 0.0 ? openLight / allLight : 1.0;
  float left = 1.0;
  if (isFloor) {
    // The share of the light that the surface leaves to the floor, which fades out at its end.
    float fromSky = brightness(gathered(sky)), fromKey = max(0.0, dot(key, sky)) * brightness(KEY_COLOUR);
    if (fromSky + fromKey > 0.0) left = (open * fromSky + keyOpen * fromKey) / (fromSky + fromKey);
    left = mix(left, 1.0, clamp(2.0 * away / FLOOR_ENDS - 1.0, 0.0, 1.0));
  }
  vec4 picture = backdrop == 2 ? vec4(vec3(0.0), 1.0 - left) : vec4(left * (backdrop == 1 ? plain : backgroundAt(uv)), 0.0);
  if (met) {
    vec3 radiance = albedo * gathered(normal) * (open + (1.0 - open) * BOUNCE * albedo);
    float facing = dot(key, normal);
    if (facing > 0.0 && keyOpen > 0.0) {
      float lobe = mirrors ? (sharpness + 8.0) / 8.0 : 1.0;
      float glint = pow(max(0.0, dot(normalize(key - direction), normal)), sharpness);
      radiance += facing * KEY_COLOUR * (albedo + lobe * glint * gloss);
    }
    if (mirrors) {
      float rest = 1.0 - clamp(-dot(normal, direction), 0.0, 1.0);
      vec3 light = environment(reflect(direction, normal));
      radiance += (gloss + square(square(rest)) * rest * (1.0 - gloss)) * mix(BOUNCE * light * albedo, light, mirrorOpen);
    }
    picture = vec4(gain * radiance, 1.0);
  }
  if (share < 1.0) picture = mix(texelFetch(before, ivec2(gl_FragCoord.xy), 0), picture, share);
  result = picture;
}
`;

const DEPTH = `
uniform sampler3D distances;  // from the target's surface
uniform vec3 distanceOrigin, distanceCount;
uniform float distanceStep;
float depthAt(vec3 x) {
  vec3 node = clamp((x - distanceOrigin) / distanceStep, vec3(0.0), distanceCount - 1.0);
  return textureLod(distances, (node + 0.5) / distanceCount, 0.0).r;
}
`;

// The whole fragment shader for a scene. Throws an Error with a message for the user if a pair cannot be translated.
export function fragmentShader(scene) {
  switch (scene.map) {
    case "shape-modulus":
      return HEADER + PRODUCT + EXPONENT + (scene.grain ? WAVE_FACTORS + GRAIN : scene.waves ? WAVE_FACTORS + WAVES
        : FACTORS + ROOTS_VERSOR) + SHAPE_STEP + LOG_POLAR_ORBIT + DEPTH + RAYS;
    case "rational":
      return HEADER + PRODUCT + FACTORS + RATIONAL_STEP + LOG_POLAR_ORBIT + DEPTH + RAYS;
    case "quadratic":
    case "mandelbulb":
    case "cross": {
      const step = { quadratic: () => QUADRATIC_STEP, mandelbulb: () => MANDELBULB_STEP, cross: crossStep }[scene.map];
      return HEADER + UNDEFINED_ITERATE + step(scene) + CARTESIAN_ORBIT + DEPTH + RAYS;
    }
    default:
      throw new Error(`The page does not know the map ${scene.map}.`);
  }
}

// Shows the mean in sRGB, and enlarges coarse pictures.
export const DISPLAY_SHADER = `#version 300 es
precision highp float;
uniform sampler2D picture;
uniform vec2 pixels;
uniform bool clear;  // the background is shown as a checkerboard
out vec4 result;
void main() {
  vec4 seen = textureLod(picture, gl_FragCoord.xy / pixels, 0.0);
  vec2 squares = floor(gl_FragCoord.xy / 12.0);
  if (clear) seen.rgb += (1.0 - seen.a) * (mod(squares.x + squares.y, 2.0) < 0.5 ? 0.20 : 0.27);
  vec3 c = clamp(seen.rgb, 0.0, 1.0);
  result = vec4(mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, vec3(greaterThan(c, vec3(0.0031308)))), 1.0);
}
`;
