// Shading of a wet surface of two layers. The light comes from one lamp beside the lens, and from
// the red cavity, which reflects it.

override SHADOW: bool = true;
// True for fewer terms, for software drivers.
override PLAIN: bool = false;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> looks: array<Look, 16>;
@group(0) @binding(2) var noise_texture: texture_3d<f32>;
@group(0) @binding(3) var noise_sampler: sampler;
@group(0) @binding(4) var shadow_map: texture_depth_2d;
@group(0) @binding(5) var shadow_sampler: sampler_comparison;
@group(0) @binding(6) var cells_texture: texture_3d<f32>;
@group(0) @binding(7) var tree_texture: texture_3d<f32>;
@group(0) @binding(8) var<uniform> trees: array<Tree, 16>;

@group(0) @binding(9) var<uniform> stains: Stains;

// Films of blood and bile on the tissue at rest (see film.rs).
@group(0) @binding(10) var film_texture: texture_3d<f32>;

// Char on the skin (see effects/stain.rs), and the box that the film texture covers.
struct Stains {
  places: array<vec4f, 64>, // middle on the tissue at rest, cm; w: radius, cm
  count: vec4u,             // number of places; 1 if any tissue is wet
  window: vec4f,            // corner of the film texture in the tissue at rest, cm
  scale: vec4f,             // cm to the texture; w: thickness of a texel of 1, mm
  up: vec4f,                // unit vector against gravity
}

// Grid of an organ's vessels (see trees.rs).
struct Tree {
  origin: vec4f,    // corner of the grid in the tissue at rest, cm; w: distance of a texel of 1, cm
  scale: vec4f,     // cm to texture; w: place along the texture's depth at which the grid starts
}

// A row of the material table (see look.rs).
struct Look {
  low: vec4f,       // darkest albedo; w: coarse frequency, 1/cm
  high: vec4f,      // lightest albedo; w: middle frequency, 1/cm
  streak: vec4f,    // colour of streaks; w: their share
  slope: vec4f,     // steepness of the bumps: middle, lobules, grain; w: of the wet film
  wet: vec4f,       // roughness, film strength, film roughness, normal reflectance
  scatter: vec4f,   // scattered light, by colour; w: fine albedo contrast
  lobule: vec4f,    // lobule frequency, grain frequency (1/cm), metal, brushed (of tissue: veins)
  // Packed cells: frequency (1/cm), steepness, darkness of furrows, lightness of middles.
  cell: vec4f,
  veil: vec4f,      // colour of a thin wall at grazing view; w: opacity
}

struct Surface {
  albedo: vec3f,
  smooth_normal: vec3f,  // of the mesh
  normal: vec3f,         // of the tissue, bumped
  film_normal: vec3f,    // of the wet film on it
  roughness: f32,
  film: f32,
  film_roughness: f32,
  reflectance: f32,
  scatter: vec3f,
  metal: f32,
  ambient: f32,
}

// Gradient noise: its gradient in xyz, its value in w. A tile has eight cells along a side.
fn noise(at: vec3f) -> vec4f { return textureSampleLevel(noise_texture, noise_sampler, at * 0.125, 0.0); }

// Noise that fades out before it is smaller than a pixel (`footprint`: cm per pixel).
fn octave(at_cm: vec3f, frequency: f32, footprint: f32) -> vec4f {
  return noise(at_cm * frequency) * (1.0 - smoothstep(0.2, 0.6, footprint * frequency));
}

// Packed cells. xyz is the slope of the dome over a cell; w is least in the furrows. Both fade as
// `octave` does.
fn cells(at_cm: vec3f, frequency: f32, footprint: f32) -> vec4f {
  let c = textureSampleLevel(cells_texture, noise_sampler, at_cm * frequency * 0.125, 0.0);
  return vec4f(c.xyz, c.w - 0.3) * (1.0 - smoothstep(0.2, 0.6, footprint * frequency));
}

// A sheet turns a height's gradient in rest space into the slope of the deformed surface. The chain
// rule leads through screen space. So bumps stick to the tissue.
struct Sheet { across: vec3f, down: vec3f, scale: f32, rest_x: vec3f, rest_y: vec3f }
fn sheet(world_x: vec3f, world_y: vec3f, rest_x: vec3f, rest_y: vec3f, normal: vec3f) -> Sheet {
  let across = cross(world_y, normal);
  let down = cross(normal, world_x);
  let det = dot(world_x, across);
  return Sheet(across, down, sign(det) / max(abs(det), 1e-16), rest_x, rest_y);
}
fn lean(s: Sheet, gradient: vec3f) -> vec3f {
  return (dot(gradient, s.rest_x) * s.across + dot(gradient, s.rest_y) * s.down) * s.scale;
}

// Slope from a height's change across and down the screen.
fn lean_screen(s: Sheet, across: f32, down: f32) -> vec3f { return (across * s.across + down * s.down) * s.scale; }

fn ggx(nh: f32, a: f32) -> f32 { let d = nh * nh * (a * a - 1.0) + 1.0; return a * a / (PI * d * d); }
fn visibility(nl: f32, nv: f32, a: f32) -> f32 {
  let a2 = a * a;
  return 0.5 / max(nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2), 1e-4);
}
fn fifth(x: f32) -> f32 { let x2 = x * x; return x2 * x2 * x; }

fn shadow(world: vec3f, normal: vec3f) -> f32 {
  if (!SHADOW) { return 1.0; }
  let h = frame.shadow_from_world * vec4f(world + normal * 0.0006, 1.0);
  let q = h.xyz / h.w;
  let uv = q.xy * vec2f(0.5, -0.5) + 0.5;
  let texel = 1.4 / f32(textureDimensions(shadow_map).x);
  var lit = 0.0;
  for (var y = -1; y <= 1; y++) {
    for (var x = -1; x <= 1; x++) {
      lit += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + vec2f(f32(x), f32(y)) * texel, q.z - 0.0005);
    }
  }
  return lit / 9.0;
}

// Share of the ambient light that the tools' capsules and gallstones do not hide (Quilez, "capsule
// occlusion").
fn hidden_by_tools(world: vec3f, normal: vec3f) -> f32 {
  var open = 1.0;
  for (var i = 0u; i < frame.counts.x; i++) {
    let a = frame.capsules[2u * i];
    let b = frame.capsules[2u * i + 1u].xyz;
    let along = b - a.xyz;
    let offset = world - a.xyz;
    let h = clamp(dot(offset, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
    let d = along * h - offset;
    let l = length(d);
    let r = min(a.w / max(l, 1e-6), 1.0);
    open *= 1.0 - 0.85 * clamp(dot(normal, d) / max(l, 1e-6), 0.0, 1.0) * r * r;
  }
  for (var i = 0u; i < frame.counts.w; i++) {
    let stone = frame.stones[i];
    let d = stone.xyz - world;
    let l2 = dot(d, d);
    let r2 = stone.w * stone.w;
    // Farther away a stone hides less than a hundredth.
    if (l2 < 60.0 * r2) {
      let share = min(r2 / max(l2, 1e-12), 1.0);
      open *= 1.0 - 0.9 * clamp(dot(normal, d) * inverseSqrt(max(l2, 1e-12)), 0.0, 1.0) * share;
    }
  }
  return open;
}

fn shade(s: Surface, world: vec3f) -> vec3f {
  let view = normalize(frame.camera.xyz - world);
  let to_light = frame.light.xyz - world;
  let d2 = dot(to_light, to_light);
  let light = to_light * inverseSqrt(d2);
  let cone = smoothstep(frame.light_axis.w, mix(frame.light_axis.w, 1.0, 0.7), dot(-light, frame.light_axis.xyz));
  let irradiance = frame.light.w * cone / (d2 + 0.0001);
  let half_way = normalize(light + view);
  let vh = max(dot(view, half_way), 0.0);
  let lit = shadow(world, s.smooth_normal);
  let ambient = s.ambient;

  // Red light travels farthest below the surface. So the smoothest normal shades it, and it leaks
  // into shadow.
  let nl = vec3f(
    dot(mix(s.smooth_normal, s.normal, 0.35), light),
    dot(mix(s.smooth_normal, s.normal, 0.85), light),
    dot(s.normal, light));
  let wrapped = clamp((nl + s.scatter) / ((1.0 + s.scatter) * (1.0 + s.scatter)), vec3f(0.0), vec3f(1.0));
  var diffuse = wrapped;
  if (SHADOW) { diffuse *= pow(vec3f(lit), vec3f(0.65, 1.0, 1.1)); }
  // Light reflected by the cavity is red, and redder still in folds.
  var folds = vec3f(ambient);
  if (!PLAIN) { folds = pow(folds, vec3f(0.75, 1.15, 1.25)); }
  let bounce = vec3f(0.055, 0.022, 0.017) * (0.65 + 0.35 * dot(s.smooth_normal, frame.up.xyz)) * folds * frame.light.w * 45.0;

  let f0 = mix(vec3f(s.reflectance), s.albedo, s.metal);
  let a = s.roughness * s.roughness;
  let nl_base = max(dot(s.normal, light), 0.0);
  let nv_base = max(dot(s.normal, view), 0.02);
  let fresnel = f0 + (1.0 - f0) * fifth(1.0 - vh);
  var base = vec3f(0.0);
  // Under a film the tissue's own reflection is dim.
  if (!PLAIN || s.metal > 0.0) {
    base = fresnel * ggx(max(dot(s.normal, half_way), 0.0), a) * visibility(nl_base, nv_base, a) * nl_base * lit;
  }

  let af = s.film_roughness * s.film_roughness;
  let nl_film = max(dot(s.film_normal, light), 0.0);
  let nv_film = max(dot(s.film_normal, view), 0.02);
  let film_fresnel = (0.028 + 0.972 * fifth(1.0 - vh)) * s.film;
  let film = film_fresnel * ggx(max(dot(s.film_normal, half_way), 0.0), af) * visibility(nl_film, nv_film, af) * nl_film * lit;

  // The film reflects the cavity dimly. The cavity is lit in front of the camera, dark behind it.
  let mirror = reflect(-view, s.film_normal);
  let before = smoothstep(-0.5, 0.9, dot(mirror, frame.forward.xyz));
  var mottled = 0.75;
  if (!PLAIN) { mottled += 0.5 * noise(mirror * 2.3 + vec3f(5.0)).w; }
  let glow = mix(vec3f(0.006, 0.0025, 0.002), vec3f(0.100, 0.040, 0.030) * mottled, before * before) * frame.light.w * 45.0;
  // Steel also reflects the white light on wet tissue: it looks grey in a red room.
  let cavity = mix(glow, vec3f(0.75 * glow.r), 0.7 * s.metal);
  // A rough film and grazing folds reflect less than a still surface.
  let mirrored = (0.028 + 0.45 * fifth(1.0 - nv_film)) * s.film + s.metal;

  // The lamp is no point, so folds and pits lose some of its light too.
  let open = mix(1.0, ambient, 0.5);
  let body = s.albedo * (1.0 - s.metal) * (diffuse * open * irradiance / PI * (1.0 - film_fresnel) + bounce * ambient);
  let tint = mix(vec3f(1.0), s.albedo, s.metal);
  return max(body + (base + film) * irradiance + cavity * mirrored * tint * ambient, vec3f(0.0));
}

// Smoke between lens and tissue absorbs light. It also scatters light of the beam back, beginning a
// little in front of the lens. Each ray is scattered once, equally in all directions.
fn through_haze(lit: vec3f, world: vec3f) -> vec3f {
  let near = 0.03;
  let far = max(length(world - frame.camera.xyz), near);
  let thick = frame.film.w;
  // Smoke attenuates the light on its way from the lamp, and again on its way back.
  let left = exp(-2.0 * thick * (far - near));
  let back = frame.light.w * thick / (4.0 * PI) * (1.0 / near - 1.0 / far) * mix(1.0, left, 0.5);
  return lit * left + vec3f(0.86, 0.87, 0.90) * back;
}
