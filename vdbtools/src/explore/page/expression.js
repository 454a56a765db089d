// SPDX-License-Identifier: Apache-2.0
// Converts the user's pairs of cross products (libjulia's expression_pair.h) to GLSL, by a recursive-descent parser of
// muParser's grammar. The GLSL is written from the parsed tree, so no text of the user reaches the compiler.

const VARIABLES = ["x", "y", "z", "r", "cos2phi", "sin2phi", "cos2theta", "sin2theta"];
const ONE = {
  sin: "sineOf", cos: "cosineOf", tan: "tan", asin: "asin", acos: "acos", atan: "atan", sinh: "sinh", cosh: "cosh",
  tanh: "tanh", exp: "exp", ln: "log", log: "log", log2: "log2", sqrt: "sqrt", abs: "abs", sign: "sign",
};
// Binary operators, in ascending order of precedence.
const LEVELS = [["||"], ["&&"], ["<=", ">=", "!=", "==", "<", ">"], ["+", "-"], ["*", "/"]];

const numberInGlsl = (value) => {
  const text = String(value);
  return /[.e]/.test(text) ? text : text + ".0";
};

class ExpressionReader {
  constructor(text) {
    this.text = text;
    this.at = 0;
  }

  fail(why) { throw new Error(`'${this.text}', character ${this.at + 1}: ${why}`); }
  skip() { while (/\s/.test(this.text[this.at] ?? "")) ++this.at; }
  takes(token) {
    this.skip();
    if (!this.text.startsWith(token, this.at)) return false;
    this.at += token.length;
    return true;
  }
  expect(token) { if (!this.takes(token)) this.fail(`'${token}' is expected`); }

  whole() {
    const result = this.choice();
    this.skip();
    if (this.at < this.text.length) this.fail("not expected here");
    return result;
  }

  choice() {
    const condition = this.binary(0);
    if (!this.takes("?")) return condition;
    const yes = this.choice();
    this.expect(":");
    return `(${condition} != 0.0 ? ${yes} : ${this.choice()})`;
  }

  binary(level) {
    if (level === LEVELS.length) return this.signed();
    let left = this.binary(level + 1);
    for (;;) {
      const operator = LEVELS[level].find((token) => this.takes(token));
      if (!operator) return left;
      const right = this.binary(level + 1);
      left = level >= 3 ? `(${left} ${operator} ${right})`
        : level === 2 ? `(${left} ${operator} ${right} ? 1.0 : 0.0)`
          : `(${left} != 0.0 ${operator} ${right} != 0.0 ? 1.0 : 0.0)`;
    }
  }

  // A sign has a lower precedence than a power: -x^2 is -(x^2).
  signed() {
    if (this.takes("-")) return `(-${this.signed()})`;
    if (this.takes("+")) return this.signed();
    const base = this.primary();
    return this.takes("^") ? `realPower(${base}, ${this.signed()})` : base;
  }

  primary() {
    if (this.takes("(")) {
      const inner = this.choice();
      this.expect(")");
      return inner;
    }
    this.skip();
    const rest = this.text.slice(this.at);
    const number = /^(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?/.exec(rest);
    if (number) {
      this.at += number[0].length;
      return numberInGlsl(Number(number[0]));
    }
    const name = /^[A-Za-z_]\w*/.exec(rest)?.[0];
    if (!name) this.fail("a number, a name or a parenthesis is expected");
    this.at += name.length;
    if (name === "pi") return "3.14159265358979";
    if (name === "e") return "2.71828182845905";
    if (VARIABLES.includes(name)) return `v_${name}`;
    return this.call(name);
  }

  call(name) {
    this.expect("(");
    const values = [this.choice()];
    while (this.takes(",")) values.push(this.choice());
    this.expect(")");
    const needs = (count) => { if (values.length !== count) this.fail(`${name} takes ${count} values`); };
    if (Object.hasOwn(ONE, name)) {
      needs(1);
      return `${ONE[name]}(${values[0]})`;
    }
    if (name === "log10") {
      needs(1);
      return `(0.4342944819 * log(${values[0]}))`;
    }
    if (name === "atan2") {
      needs(2);
      return `atan(${values[0]}, ${values[1]})`;
    }
    if (name === "min" || name === "max") return values.reduce((all, value) => `${name}(${all}, ${value})`);
    return this.fail(`'${name}' is not known to the page`);
  }
}

// Splits at the commas outside parentheses.
function componentsOf(text) {
  const parts = [""];
  let depth = 0;
  for (const c of text) {
    depth += c === "(" ? 1 : c === ")" ? -1 : 0;
    if (c === "," && depth === 0) parts.push("");
    else parts[parts.length - 1] += c;
  }
  if (parts.length !== 3) throw new Error(`'${text}' has ${parts.length} components; it must have 3`);
  return parts;
}

export function expressionInGlsl(text) { return new ExpressionReader(text).whole(); }

// The functions userFirst() and userSecond(). Throws an Error that names the character which cannot be translated.
export function pairInGlsl(f, g) {
  const made = (name, text) => `
vec3 ${name}(vec3 p) {
  float v_x = p.x, v_y = p.y, v_z = p.z, v_r = length(p), flat_ = dot(p.xy, p.xy), all = dot(p, p);
  float v_cos2phi = flat_ > 1e-36 ? (p.x * p.x - p.y * p.y) / flat_ : 1.0;
  float v_sin2phi = flat_ > 1e-36 ? 2.0 * p.x * p.y / flat_ : 0.0;
  float v_cos2theta = all > 1e-36 ? (flat_ - p.z * p.z) / all : 1.0;
  float v_sin2theta = all > 1e-36 ? 2.0 * sqrt(flat_) * p.z / all : 0.0;
  return vec3(${componentsOf(text).map(expressionInGlsl).join(", ")});
}`;
  return `
// GLSL's pow() does not accept a negative base.
float realPower(float base, float power) {
  if (base >= 0.0) return power == 0.0 ? 1.0 : pow(base, power);
  float size = pow(-base, power);
  return power != floor(power) ? UNDEFINED : mod(power, 2.0) == 0.0 ? size : -size;
}
${made("userFirst", f)}
${made("userSecond", g)}
`;
}
