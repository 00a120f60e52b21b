// From light to picture: the scope's lens and circle, exposure, sharpening, tone curve, grain.

override BLOOM: bool = true;
// True to smooth edges, for light with one sample a pixel.
override SMOOTH: bool = false;
// True for neither blur nor colour fringes, for software drivers.
override PLAIN: bool = false;
struct Exposure { value: f32, unused0: f32, unused1: f32, unused2: f32 }

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var light: texture_2d<f32>;
@group(0) @binding(2) var glare: texture_2d<f32>;
@group(0) @binding(3) var linear: sampler;
@group(0) @binding(4) var<storage, read> exposure: Exposure;

// Aperture of the endoscope. It is small, so the depth of field is large.
const APERTURE_M = 0.00028;

struct VertexOut { @builtin(position) clip: vec4f, @location(0) ndc: vec2f }

@vertex fn vertex(@builtin(vertex_index) index: u32) -> VertexOut {
  let at = full_screen(index);
  return VertexOut(at, at.xy);
}

// Place in the source picture of a place in the finished picture. In the finished picture, the
// radius grows with the angle off the view; in the source picture, with the angle's tangent.
fn through_lens(at: vec2f) -> vec2f {
  let r = length(at);
  let angle = r / frame.scope.y * frame.scope.x;
  var k = frame.scope.x / frame.scope.y;
  if (PLAIN) {
    let a2 = angle * angle;
    k *= 1.0 + a2 * (0.33333 + a2 * (0.13333 + 0.053968 * a2));
  } else if (r >= 1e-4) {
    k = tan(angle) / r;
  }
  k /= frame.forward.w;
  return vec2f(at.x / frame.up.w, -at.y) * k * 0.5 + 0.5;
}

// Fitted ACES curve (Narkowicz 2016).
fn tone(x: vec3f) -> vec3f {
  return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), vec3f(0.0), vec3f(1.0));
}

// Brightness with which the screen shows this light, roughly: 0 to 1.
fn compressed(c: vec3f) -> vec3f { let e = c * exposure.value; return e / (0.35 + e); }

// The light at a place on an edge, averaged along the edge (Lottes 2009, "FXAA"). `around` is the
// green light of the nearest texels: lower left, lower right, upper right, upper left.
fn smoothed(c: vec3f, uv: vec2f, texel: vec2f, around: vec4f) -> vec3f {
  let g = around * exposure.value / (0.35 + around * exposure.value);
  let least = min(min(g.x, g.y), min(g.z, g.w));
  let most = max(max(g.x, g.y), max(g.z, g.w));
  if (most - least < max(0.05, 0.18 * most)) { return c; }
  let across = vec2f((g.x + g.y) - (g.z + g.w), (g.x + g.w) - (g.y + g.z));
  let shorten = 1.0 / (min(abs(across.x), abs(across.y)) + max(0.03125 * dot(g, vec4f(1.0)), 0.0078));
  let along = clamp(across * shorten, vec2f(-6.0), vec2f(6.0)) * texel;
  let near = 0.5 * (compressed(textureSampleLevel(light, linear, uv - along / 6.0, 0.0).rgb)
    + compressed(textureSampleLevel(light, linear, uv + along / 6.0, 0.0).rgb));
  let far = 0.5 * near + 0.25 * (compressed(textureSampleLevel(light, linear, uv - 0.5 * along, 0.0).rgb)
    + compressed(textureSampleLevel(light, linear, uv + 0.5 * along, 0.0).rgb));
  let mean = select(far, near, far.g < least || far.g > most);
  return 0.35 * mean / (1.0 - min(mean, vec3f(0.995))) / exposure.value;
}

// Noise from -1 to 1 that varies smoothly over a length of 1.
fn drops(at: vec2f) -> vec3f {
  let cell = vec2u(at);
  let t = fract(at);
  let s = t * t * (3.0 - 2.0 * t);
  let a = mix(hash3(vec3u(cell, 7u)), hash3(vec3u(cell + vec2u(1u, 0u), 7u)), s.x);
  let b = mix(hash3(vec3u(cell + vec2u(0u, 1u), 7u)), hash3(vec3u(cell + 1u, 7u)), s.x);
  return mix(a, b, s.y);
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let at = vec2f(in.ndc.x * frame.up.w, in.ndc.y);
  let r = length(at) / frame.scope.y;
  let soft = 3.0 / frame.scope.w;
  let open = 1.0 - smoothstep(1.0 - 2.0 * soft, 1.0 + soft, r);
  if (open <= 0.0) { return vec4f(0.004, 0.004, 0.005, 1.0); }
  let uv = through_lens(at);
  let texel = f32(frame.counts.z) / frame.scope.zw;
  let straight = textureSampleLevel(light, linear, uv, 0.0);
  var c = straight.rgb;
  var around = vec4f(0.0);
  if (SMOOTH) {
    around = textureGather(1, light, linear, uv);
    c = smoothed(c, uv, texel, around);
  } else {
    let fringe = (uv - 0.5) * r * r * 0.003;
    c.r = textureSampleLevel(light, linear, uv + fringe, 0.0).r;
    c.b = textureSampleLevel(light, linear, uv - fringe, 0.0).b;
  }
  // A point out of focus appears as a disc. `disc` is the disc's angular radius, rad.
  let disc = 0.5 * APERTURE_M * abs(1.0 / max(straight.a, 0.004) - 1.0 / max(frame.wear.w, 0.004))
    * step(0.0001, straight.a) * step(0.0001, frame.wear.w);
  let reach = vec2f(1.0 / frame.up.w, 1.0) * min(0.5 * disc * frame.scope.y / frame.scope.x, 0.02);
  if (!PLAIN && reach.y > 0.6 * texel.y) {
    for (var i = 1u; i < 13u; i++) {
      let turn = f32(i) * 2.399963;
      c += textureSampleLevel(light, linear, uv + vec2f(cos(turn), sin(turn)) * sqrt(f32(i) / 12.0) * reach, 0.0).rgb;
    }
    c /= 13.0;
  }
  // Fog is many small drops. Each drop scatters light from elsewhere into its place. Together they
  // make the picture dim and grey.
  let fog = clamp(frame.film.y * (1.35 - 0.5 * r), 0.0, 1.0);
  let veil = max(fog, frame.film.z);
  if (veil > 0.002) {
    let drop = drops((at + 4.0) * 95.0);
    var sum = vec3f(0.0);
    for (var i = 0u; i < 8u; i++) {
      let turn = f32(i) * 2.399963 + drop.z;
      let reach = veil * (0.010 + 0.022 * f32(i) / 8.0);
      let to = vec2f(cos(turn), sin(turn)) * reach + drop.xy * fog * 0.005;
      sum += textureSampleLevel(light, linear, uv + to, 0.0).rgb;
    }
    let blurred = sum / 8.0;
    let grey = vec3f(dot(blurred, vec3f(0.3, 0.5, 0.2)));
    c = mix(c, mix(blurred, grey, 0.35) * (1.0 - 0.45 * frame.film.z) + 0.25 * grey * fog, clamp(1.6 * veil, 0.0, 1.0));
  }
  // A camera sharpens brightness.
  var sum = dot(around, vec4f(1.0));
  if (!SMOOTH) {
    sum = textureSampleLevel(light, linear, uv + vec2f(texel.x, 0.0), 0.0).g
      + textureSampleLevel(light, linear, uv - vec2f(texel.x, 0.0), 0.0).g
      + textureSampleLevel(light, linear, uv + vec2f(0.0, texel.y), 0.0).g
      + textureSampleLevel(light, linear, uv - vec2f(0.0, texel.y), 0.0).g;
  }
  let sharp = (1.0 - veil) * (1.0 - smoothstep(0.3, 1.0, reach.y / texel.y));
  c *= 1.0 + 0.3 * sharp * clamp((c.g * 4.0 - sum) / max(c.g * 4.0 + sum, 1e-4), -0.6, 0.6);
  c *= exposure.value;
  if (BLOOM) { c += textureSampleLevel(glare, linear, uv, 0.0).rgb * 0.09; }
  c *= 1.0 - 0.42 * smoothstep(0.35, 1.05, r);
  var shown = tone(c);
  if (PLAIN) {
    let root = sqrt(shown);
    shown = root + 0.06 * sqrt(root) * (1.0 - shown);
  } else {
    shown = pow(shown, vec3f(1.0 / 2.2));
  }
  shown += hash3(vec3u(vec2u(in.clip.xy), frame.counts.y)) * frame.film.x * (1.2 - shown);
  return vec4f(mix(vec3f(0.004), clamp(shown, vec3f(0.0), vec3f(1.0)), open), 1.0);
}
