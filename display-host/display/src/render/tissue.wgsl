// Organs and the cavity around them.

// Level of detail. 0 draws one octave of noise, for software drivers, 1 draws two, and 2 four.
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

// Thickness of a film above which its surface is drawn above the tissue, mm.
const POOL_MM = 0.3;

// Height by which a film raises the surface at a vertex, m. On level ground it is the film's
// thickness; a wall or a ceiling holds no pool.
fn pool_m(p: vec3f, normal: vec3f) -> f32 {
  if (stains.count.y == 0u) { return 0.0; }
  let at = (p - stains.window.xyz) * stains.scale.xyz;
  if (any(at <= vec3f(0.0)) || any(at >= vec3f(1.0))) { return 0.0; }
  let root = textureSampleLevel(film_texture, noise_sampler, at, 0.0);
  let mm = dot((root * root).xyw, vec3f(1.0)) * stains.scale.w;
  return 0.001 * max(mm - POOL_MM, 0.0) * smoothstep(0.2, 0.8, dot(normal, stains.up.xyz));
}

@vertex fn vertex(v: VertexIn) -> VertexOut {
  var out: VertexOut;
  out.world = v.position.xyz;
  out.normal = v.normal.xyz;
  if (v.position.w < 0.0) {
    // A negative push is the negated radius of a fibre. A fibre thinner than a pixel would have
    // gaps, so it is widened.
    let pixel = 2.0 * depth_of(out.world) * frame.forward.w / frame.scope.w * f32(frame.counts.z);
    let radius = -v.position.w / pixel;
    out.world += out.normal * max(FIBRE_PX - radius, 0.0) * pixel;
    // A thin fibre has the mean normal of its visible surface, so that its sides do not flicker
    // from pixel to pixel. The normal is inclined, so that the fibre does not glare.
    let whole = normalize(normalize(frame.camera.xyz - out.world) + 0.8 * frame.up.xyz);
    out.normal = normalize(mix(whole, out.normal, smoothstep(1.0, 3.0, radius)));
  }
  out.rest_cm = v.rest * 100.0;
  if (v.position.w >= 0.0) { out.world += stains.up.xyz * pool_m(out.rest_cm, out.normal); }
  out.clip = frame.clip_from_world * vec4f(out.world, 1.0);
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
    // The noise of middle frequency distorts the cells, so that they are irregular.
    packed = cells(p + 0.25 / look.cell.x * middle.xyz, look.cell.x, footprint);
    b.albedo *= 1.0 + select(look.cell.z, look.cell.w, packed.w > 0.0) * packed.w;
  }

  // Fine, intermittent vessels run along the zero crossings of noise.
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

// Two numbers for each fluid, in red, green and blue. One is the colour of a deep layer. The other
// is the attenuation, 1/mm, by which a film weakens the light that the tissue sends back. Blood has
// 150 g/l of haemoglobin (S. Prahl's table at 630, 540 and 460 nm). Fresh blood has 85 % of its
// oxygen, clotted blood none. Its reduced scattering is 1.5/mm, and the attenuation follows by
// Kubelka and Munk. Colours of deep fluid were set by eye, and all of bile's numbers are assumed.
const FRESH = vec3f(0.030, 0.0012, 0.0016);
const FRESH_TAKES = vec3f(4.4, 114.0, 91.0);
const CLOT = vec3f(0.020, 0.0016, 0.0022);
const CLOT_TAKES = vec3f(13.0, 102.0, 52.0);
const BILE = vec3f(0.034, 0.0185, 0.0016);
const BILE_TAKES = vec3f(0.9, 2.3, 12.0);
// Thinnest visible film, and thickness at which it covers all of the tissue's relief, mm.
const RIM_MM = vec2f(0.010, 0.260);

// Share of char at a place of the tissue at rest: 0 to 1.
fn charred(p: vec3f, rough: f32) -> f32 {
  var most = 0.0;
  for (var i = 0u; i < min(stains.count.x, 64u); i++) {
    let to = p - stains.places[i].xyz;
    most = max(most, 1.0 - smoothstep(0.55, 1.0, length(to) / stains.places[i].w + rough));
  }
  return most;
}

// Four samples of the film texture, mixed: `near_x` and `near_y` are the shares of the first ones.
fn film_row(ax: f32, bx: f32, near_x: f32, ay: f32, by: f32, near_y: f32, z: f32) -> vec4f {
  let aa = textureSampleLevel(film_texture, noise_sampler, vec3f(ax, ay, z), 0.0);
  let ba = textureSampleLevel(film_texture, noise_sampler, vec3f(bx, ay, z), 0.0);
  let ab = textureSampleLevel(film_texture, noise_sampler, vec3f(ax, by, z), 0.0);
  let bb = textureSampleLevel(film_texture, noise_sampler, vec3f(bx, by, z), 0.0);
  return mix(mix(bb, ab, near_x), mix(ba, aa, near_x), near_y);
}

// Thickness of the film at a place of the tissue at rest: blood, bile, clotted blood, water, mm.
fn film_at(p: vec3f) -> vec4f {
  if (stains.count.y == 0u) { return vec4f(0.0); }
  let at = (p - stains.window.xyz) * stains.scale.xyz;
  if (any(at <= vec3f(0.0)) || any(at >= vec3f(1.0))) { return vec4f(0.0); }
  // Cubic B-spline: straight mixing would show the grid's cells as corners of the film's rim. Eight
  // samples, each a mix of eight texels (Sigg and Hadwiger, GPU Gems 2, chapter 20).
  let size = vec3f(textureDimensions(film_texture));
  let texel = at * size - 0.5;
  let low = floor(texel);
  let f = texel - low;
  let e = 1.0 - f;
  let w0 = e * e * e / 6.0;
  let w1 = 2.0 / 3.0 - f * f * (1.0 - 0.5 * f);
  let w3 = f * f * f / 6.0;
  let near = w0 + w1;
  let a = (low - 0.5 + w1 / near) / size;
  let b = (low + 1.5 + w3 / (1.0 - near)) / size;
  let front = film_row(a.x, b.x, near.x, a.y, b.y, near.y, a.z);
  let back = film_row(a.x, b.x, near.x, a.y, b.y, near.y, b.z);
  let root = mix(back, front, near.z);
  return root * root * stains.scale.w;
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let world_x = dpdx(in.world) * 100.0;
  let world_y = dpdy(in.world) * 100.0;
  let rest_x = dpdx(in.rest_cm);
  let rest_y = dpdy(in.rest_cm);
  let footprint = max(length(rest_x), length(rest_y));
  let p = in.rest_cm;

  // Distances to the edges of the nearest artery and the nearest vein of the organ's tree, cm.
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
  let film = film_at(p);
  // Change of the film's height over the tissue across and down the screen, cm.
  let film_x = dpdx(0.1 * (film.x + film.y + film.w));
  let film_y = dpdy(0.1 * (film.x + film.y + film.w));

  var b = body(looks[in.look & 15u], p, footprint, slot != 0u);
  if (in.state.w > 0.0) {
    let other = body(looks[(in.look >> 4u) & 15u], p, footprint, false);
    b = between(b, other, in.state.w);
  }
  var s: Surface;
  s.albedo = b.albedo;
  if (slot != 0u) {
    // The vessels lie under the serosa. Tissue around them is reddened, and the vein looks deeper
    // and bluer than the artery.
    let near = 1.0 - smoothstep(0.0, tree.origin.w, edge);
    s.albedo *= mix(vec3f(1.0), vec3f(1.02, 0.80, 0.78), near);
    s.albedo = mix(s.albedo, s.albedo * vec3f(0.55, 0.20, 0.30) + vec3f(0.012, 0.002, 0.005), 0.62 * vein);
    s.albedo = mix(s.albedo, vec3f(0.17, 0.024, 0.020), 0.58 * artery);
  }

  // Where skin is pressed, the ridge is pale, and the pit lies in its own shade.
  let bend = in.state.y;
  let pushed = in.state.z;
  let pressed = smoothstep(8.0, 70.0, -bend) * smoothstep(0.0002, 0.002, pushed);
  let pit = smoothstep(0.002, 0.010, pushed);
  s.albedo *= mix(vec3f(1.0), vec3f(1.2, 1.5, 1.4), 0.6 * pressed);
  s.albedo *= mix(vec3f(1.0), vec3f(0.66, 0.48, 0.48), pit);

  s.smooth_normal = normalize(in.normal);
  let skin = sheet(world_x, world_y, rest_x, rest_y, s.smooth_normal);
  // A vessel stands out a little, because its flanks are inclined. Flanks smaller than a pixel are
  // left out.
  let flank = select(0.0, 0.12 * exp(-edge * edge / 0.0006) * (1.0 - smoothstep(0.01, 0.03, footprint)), slot != 0u);
  let vessels = -flank * lean_screen(skin, edge_x, edge_y);
  s.normal = normalize(s.smooth_normal - lean(skin, b.bump) - vessels);
  s.film_normal = normalize(s.smooth_normal - lean(skin, b.wet));
  // A thin wall shows its own colour at grazing view. Head on, it shows what lies behind it.
  let along = 1.0 - clamp(dot(s.smooth_normal, normalize(frame.camera.xyz - in.world)), 0.0, 1.0);
  s.albedo = mix(s.albedo, b.veil.rgb, b.veil.w * along * along);
  s.roughness = b.sheen.x;
  s.film = b.sheen.y;
  s.film_roughness = b.sheen.z;
  s.reflectance = b.sheen.w;
  s.scatter = b.scatter;
  s.metal = 0.0;
  // Noise makes the edges of char and films rough, more finely than a mesh or grid could. The noise
  // follows the tissue.
  var rough = 0.0;
  if (stains.count.x + stains.count.y > 0u) {
    rough = 0.34 * noise(p * 5.0).w;
    if (!PLAIN) { rough += 0.13 * noise(p * 13.0).w; }
  }
  let char = charred(p, rough);
  if (char > 0.0) {
    // Char is dull and cracked.
    s.albedo = mix(s.albedo, vec3f(0.012, 0.0095, 0.008), 0.95 * char);
    s.film = mix(s.film, 0.15, char);
    s.roughness = mix(s.roughness, 0.75, char);
    s.scatter = mix(s.scatter, vec3f(0.05), char);
  }
  let total = film.x + film.y + film.w;
  let rim = smoothstep(RIM_MM.x, RIM_MM.y, total * (1.0 + 1.6 * rough));
  if (rim > 0.0) {
    let blood = film.x * rim;
    let bile = film.y * rim;
    let old = clamp(film.z / max(film.x, 1e-4), 0.0, 1.0);
    // A thicker film takes more of the tissue's light, by colour, and shows more of its own colour.
    s.albedo = BILE + (s.albedo - BILE) * exp(-bile * BILE_TAKES);
    let own = mix(FRESH, CLOT, old);
    s.albedo = own + (s.albedo - own) * exp(-blood * mix(FRESH_TAKES, CLOT_TAKES, old));
    // A film fills the tissue's bumps, bulges at its rim, and lies level where it is deep.
    let deep = smoothstep(0.3, 1.5, total);
    let bulge = lean_screen(skin, film_x, film_y);
    let steep = 0.9 * bulge * (1.0 / max(1.0, length(bulge)));
    let level = max(dot(s.smooth_normal, stains.up.xyz), 0.0);
    let flat_normal = normalize(mix(s.smooth_normal, stains.up.xyz, 0.8 * deep * level));
    let fills = rim * mix(0.55, 1.0, smoothstep(0.05, 0.4, total));
    s.normal = normalize(mix(s.normal, flat_normal - 0.5 * steep, fills));
    s.film_normal = normalize(mix(s.film_normal, flat_normal - steep, fills));
    // Clotted blood is a jelly with a skin of its own.
    let ripples = mix(0.45, 0.9, old) * b.wet;
    s.film_normal = normalize(s.film_normal - lean(skin, ripples));
    s.film_roughness = mix(s.film_roughness, mix(0.075, 0.12, old), rim);
    s.film = mix(s.film, 1.0, rim);
    s.roughness = mix(s.roughness, 0.5, rim);
    // Clear water lets the tissue's own light through.
    let murky = (film.x + film.y) / max(total, 1e-4);
    s.scatter = mix(s.scatter, vec3f(0.16, 0.05, 0.05), fills * murky);
  }
  s.ambient = in.state.x * hidden_by_tools(in.world, s.smooth_normal) * (1.0 - 0.7 * pit);
  return vec4f(through_haze(shade(s, in.world), in.world), depth_of(in.world));
}
