// Organs and the cavity around them.

// 0: one octave, for software drivers; 1: two; 2: four.
override DETAIL: u32 = 2u;

// Least drawn radius of a fibre, pixels.
const FIBRE_PX = 0.65;

struct VertexIn {
  @location(0) position: vec4f,
  @location(1) normal: vec4f,
  @location(2) rest: vec3f,
  @location(3) look: u32,
  @location(5) ambient: f32,
}
struct VertexOut {
  @builtin(position) clip: vec4f,
  @location(0) world: vec3f,
  @location(1) normal: vec3f,
  @location(2) rest_cm: vec3f,
  @location(3) @interpolate(flat) look: u32,
  @location(4) state: vec4f, // ambient light, bend, push, share of the second look
}

@vertex fn vertex(v: VertexIn) -> VertexOut {
  var out: VertexOut;
  out.world = v.position.xyz;
  out.normal = v.normal.xyz;
  if (v.position.w < 0.0) {
    // A fibre, with its radius in place of the push: thinner than a pixel it would have gaps.
    let pixel = 2.0 * depth_of(out.world) * frame.forward.w / frame.scope.w * f32(frame.counts.z);
    let radius = -v.position.w / pixel;
    out.world += out.normal * max(FIBRE_PX - radius, 0.0) * pixel;
    // Its sides must not flicker from pixel to pixel: a thin fibre has the mean normal of its
    // visible surface, inclined so that it does not glare.
    let whole = normalize(normalize(frame.camera.xyz - out.world) + 0.8 * frame.up.xyz);
    out.normal = normalize(mix(whole, out.normal, smoothstep(1.0, 3.0, radius)));
  }
  out.clip = frame.clip_from_world * vec4f(out.world, 1.0);
  out.rest_cm = v.rest * 100.0;
  out.look = v.look;
  out.state = vec4f(v.ambient, v.normal.w, max(v.position.w, 0.0), f32(v.look >> 16u) / 65535.0);
  return out;
}

@vertex fn cast_shadow(@location(0) position: vec4f) -> @builtin(position) vec4f {
  return frame.shadow_from_world * vec4f(position.xyz, 1.0);
}

// Tissue properties at a point.
struct Body {
  albedo: vec3f,
  bump: vec3f,    // slope of the tissue, in rest space
  wet: vec3f,     // slope of the film on it
  sheen: vec4f,   // roughness, film strength, film roughness, normal reflectance
  scatter: vec3f,
  veil: vec4f,
}

// Coverage of a line whose edge is `d` cm away (negative: inside).
fn cover(d: f32, footprint: f32) -> f32 {
  let soft = max(0.8 * footprint, 0.008);
  return 1.0 - smoothstep(-soft, soft, d);
}

fn body(look: Look, p: vec3f, footprint: f32, has_tree: bool) -> Body {
  var coarse = vec4f(0.0);
  if (!PLAIN) { coarse = noise(p * look.low.w); }
  let middle = octave(p + vec3f(3.1, 0.7, 5.3), look.high.w, footprint);
  var lobule = vec4f(0.0);
  var grain = vec4f(0.0);
  if (DETAIL >= 2u) {
    lobule = octave(p + vec3f(9.2, 4.4, 1.1), look.lobule.x, footprint);
    grain = octave(p, look.lobule.y, footprint);
  }
  var b: Body;
  b.albedo = mix(look.low.rgb, look.high.rgb, clamp(0.5 + 0.75 * coarse.w + 0.45 * middle.w, 0.0, 1.0));
  let streak = smoothstep(0.0, 0.75, middle.w - 0.45 * coarse.w + 0.35 * lobule.w) * look.streak.w;
  b.albedo = mix(b.albedo, look.streak.rgb, streak);
  b.albedo *= 1.0 + look.scatter.w * (lobule.w + 0.5 * grain.w);
  var packed = vec4f(0.0);
  if (!PLAIN && look.cell.x > 0.0) {
    // The cells are irregular: distorted by the layer below.
    packed = cells(p + 0.25 / look.cell.x * middle.xyz, look.cell.x, footprint);
    b.albedo *= 1.0 + select(look.cell.z, look.cell.w, packed.w > 0.0) * packed.w;
  }

  // Fine, intermittent vessels at the zero crossings of noise.
  if (!PLAIN && look.lobule.w > 0.0 && !has_tree) {
    let line = octave(p + vec3f(17.3, 2.9, 8.1), look.high.w * 0.8, footprint).w + 0.15 * lobule.w;
    let there = smoothstep(-0.15, 0.35, coarse.w + 0.3 * middle.w);
    let vein = (1.0 - smoothstep(0.005, 0.040, abs(line))) * there * look.lobule.w;
    b.albedo = mix(b.albedo, vec3f(0.13, 0.016, 0.015), vein);
  }
  b.bump = look.slope.x * middle.xyz + look.slope.y * lobule.xyz + look.slope.z * grain.xyz + look.cell.y * packed.xyz;
  b.wet = look.slope.w * (middle.xyz + 0.35 * lobule.xyz + 0.3 * grain.xyz) + 0.6 * look.cell.y * packed.xyz;
  b.sheen = look.wet;
  b.scatter = look.scatter.rgb;
  b.veil = look.veil;
  return b;
}

fn between(a: Body, b: Body, t: f32) -> Body {
  return Body(mix(a.albedo, b.albedo, t), mix(a.bump, b.bump, t), mix(a.wet, b.wet, t),
    mix(a.sheen, b.sheen, t), mix(a.scatter, b.scatter, t), mix(a.veil, b.veil, t));
}

// Optical depths of the thickest film of bile and of blood: red, green, blue.
const BILE_DEPTHS = vec3f(0.7, 0.6, 3.0);
const BLOOD_DEPTHS = vec3f(2.0, 7.0, 7.0);

// Thickness of blood, bile and char here: 0 to 1.
fn stained(p: vec3f) -> vec3f {
  var most = vec3f(0.0);
  if (stains.count.x == 0u) { return most; }
  // An edge finer than any mesh: it follows the tissue and thins out.
  var rough = 0.34 * noise(p * 5.0).w;
  if (!PLAIN) { rough += 0.13 * noise(p * 13.0).w; }
  for (var i = 0u; i < min(stains.count.x, 64u); i++) {
    let to = p - stains.places[i].xyz;
    let r = length(to) / stains.places[i].w;
    let there = 1.0 - smoothstep(0.55, 1.0, r + rough);
    let kind = u32(stains.kinds[i].x);
    most = max(most, there * vec3f(vec3u(kind) == vec3u(0u, 1u, 2u)));
  }
  return most;
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let world_x = dpdx(in.world) * 100.0;
  let world_y = dpdy(in.world) * 100.0;
  let rest_x = dpdx(in.rest_cm);
  let rest_y = dpdy(in.rest_cm);
  let footprint = max(length(rest_x), length(rest_y));
  let p = in.rest_cm;

  // Vessels of the organ's tree: artery and vein, distance to their edges in cm.
  let slot = (in.look >> 8u) & 15u;
  let tree = trees[slot];
  let grid = (p - tree.origin.xyz) * tree.scale.xyz + vec3f(0.0, 0.0, tree.scale.w);
  var edges = vec2f(1.0);
  if (slot != 0u) {
    edges = (0.5 - textureSampleLevel(tree_texture, noise_sampler, grid, 0.0).xy) * 2.0 * tree.origin.w;
  }
  let artery = cover(edges.x, footprint);
  let vein = cover(edges.y, footprint);
  let edge = min(edges.x, edges.y);
  let edge_x = dpdx(edge);
  let edge_y = dpdy(edge);

  var b = body(looks[in.look & 15u], p, footprint, slot != 0u);
  if (in.state.w > 0.0) {
    let other = body(looks[(in.look >> 4u) & 15u], p, footprint, false);
    b = between(b, other, in.state.w);
  }
  var s: Surface;
  s.albedo = b.albedo;
  if (slot != 0u) {
    // Under the serosa: reddened around, the vein deeper and bluer than the artery.
    let near = 1.0 - smoothstep(0.0, tree.origin.w, edge);
    s.albedo *= mix(vec3f(1.0), vec3f(1.02, 0.80, 0.78), near);
    s.albedo = mix(s.albedo, s.albedo * vec3f(0.55, 0.20, 0.30) + vec3f(0.012, 0.002, 0.005), 0.62 * vein);
    s.albedo = mix(s.albedo, vec3f(0.17, 0.024, 0.020), 0.58 * artery);
  }

  // Pressed skin: the ridge is pale, the pit lies in its own shade.
  let bend = in.state.y;
  let pushed = in.state.z;
  let pressed = smoothstep(8.0, 70.0, -bend) * smoothstep(0.0002, 0.002, pushed);
  let pit = smoothstep(0.002, 0.010, pushed);
  s.albedo *= mix(vec3f(1.0), vec3f(1.2, 1.5, 1.4), 0.6 * pressed);
  s.albedo *= mix(vec3f(1.0), vec3f(0.66, 0.48, 0.48), pit);

  s.smooth_normal = normalize(in.normal);
  let skin = sheet(world_x, world_y, rest_x, rest_y, s.smooth_normal);
  // A vessel stands out a little: its flanks are inclined, unless they are smaller than a pixel.
  let flank = select(0.0, 0.12 * exp(-edge * edge / 0.0006) * (1.0 - smoothstep(0.01, 0.03, footprint)), slot != 0u);
  let vessels = -flank * lean_screen(skin, edge_x, edge_y);
  s.normal = normalize(s.smooth_normal - lean(skin, b.bump) - vessels);
  s.film_normal = normalize(s.smooth_normal - lean(skin, b.wet));
  // A thin wall shows its own colour at grazing view, and the background head on.
  let along = 1.0 - clamp(dot(s.smooth_normal, normalize(frame.camera.xyz - in.world)), 0.0, 1.0);
  s.albedo = mix(s.albedo, b.veil.rgb, b.veil.w * along * along);
  s.roughness = b.sheen.x;
  s.film = b.sheen.y;
  s.film_roughness = b.sheen.z;
  s.reflectance = b.sheen.w;
  s.scatter = b.scatter;
  s.metal = 0.0;
  let wet = stained(p);
  if (wet.x + wet.y + wet.z > 0.0) {
    // A film fills the tissue's bumps and shines; char is dull and cracked.
    let film = smoothstep(0.0, 0.35, max(wet.x, wet.y));
    s.albedo = mix(s.albedo, vec3f(0.012, 0.0095, 0.008), 0.95 * wet.z);
    // A thicker film absorbs more of the tissue's light, by colour (Beer's law), and shows more of
    // its own.
    s.albedo = s.albedo * exp(-wet.y * BILE_DEPTHS) + vec3f(0.036, 0.031, 0.003) * wet.y;
    s.albedo = s.albedo * exp(-wet.x * BLOOD_DEPTHS) + vec3f(0.042, 0.0014, 0.0016) * wet.x;
    s.normal = normalize(mix(s.normal, s.smooth_normal, 0.6 * film));
    s.film_normal = normalize(mix(s.film_normal, s.smooth_normal, 0.7 * film));
    s.film_roughness = mix(s.film_roughness, 0.055, film);
    s.film = mix(mix(s.film, 0.15, wet.z), 1.0, film);
    s.roughness = mix(s.roughness, 0.75, wet.z);
    s.scatter = mix(s.scatter, vec3f(0.05), max(wet.z, 0.7 * film));
  }
  s.ambient = in.state.x * hidden_by_tools(in.world, s.smooth_normal) * (1.0 - 0.7 * pit);
  return vec4f(through_haze(shade(s, in.world), in.world), depth_of(in.world));
}
