// Instruments: rigid parts of steel, plastic and ceramic. Gallstones.

@group(1) @binding(0) var<uniform> world_from_part: array<mat4x4f, 64>;

struct VertexIn {
  @location(0) position: vec3f,
  @location(1) look: u32,
  @location(2) normal: vec3f,
  @location(3) part: u32,
}
struct VertexOut {
  @builtin(position) clip: vec4f,
  @location(0) world: vec3f,
  @location(1) normal: vec3f,
  @location(2) part_cm: vec3f,
  @location(3) @interpolate(flat) look: u32,
  @location(4) @interpolate(flat) part: u32,
}

@vertex fn vertex(v: VertexIn) -> VertexOut {
  let m = world_from_part[v.part & 63u];
  let world = m * vec4f(v.position, 1.0);
  var out: VertexOut;
  out.clip = frame.clip_from_world * world;
  out.world = world.xyz;
  out.normal = (m * vec4f(v.normal, 0.0)).xyz;
  out.part_cm = v.position * 100.0;
  out.look = v.look;
  out.part = v.part;
  return out;
}

@vertex fn cast_shadow(v: VertexIn) -> @builtin(position) vec4f {
  return frame.shadow_from_world * world_from_part[v.part & 63u] * vec4f(v.position, 1.0);
}

// Shares of char, blood and bile at a place of the working end. They lie in patches, most at the
// tip, and the patches merge as they grow.
fn soiled(p: vec3f, part: u32, brushed: f32) -> vec3f {
  // Trocar and clips stay clean.
  if (part > 2u || p.z > 0.6) { return vec3f(0.0); }
  let patches = 0.6 * noise(p * 5.0 + vec3f(4.0)).w + 0.35 * noise(p * 17.0).w + 0.1 * brushed;
  let to_tip = smoothstep(-0.4, 1.6, -p.z);
  let bent = smoothstep(0.75, 1.1, -p.z);
  let blood = frame.wear.yz * 1.5 - 1.0 + 0.75 * to_tip + patches;
  let char = frame.wear.x * 1.9 - 1.6 + bent + 0.7 * patches;
  return vec3f(
    smoothstep(-0.06, 0.12, char) * step(0.001, frame.wear.x),
    smoothstep(vec2f(-0.05), vec2f(0.05), blood) * step(vec2f(0.001), frame.wear.yz));
}

// A gallstone of radius 1 (see stones.rs). Its number gives its tint.
fn gallstone(in: VertexOut, footprint: f32) -> Surface {
  let own = hash3(vec3u(in.part, 17u, 5u));
  let m = world_from_part[in.part & 63u];
  let turn = mat3x3f(normalize(m[0].xyz), normalize(m[1].xyz), normalize(m[2].xyz));
  let p = in.part_cm * 0.01;
  let at = p + own * 3.0;
  let broad = octave(at, 1.1, footprint);
  let middle = octave(at + vec3f(7.0), 3.4, footprint);
  let fine = octave(at + vec3f(3.0), 9.0, footprint);
  // Cholesterol and pigment lie in layers and patches.
  let dark = clamp(0.45 + 0.35 * own.x + 0.9 * broad.w + 0.45 * middle.w, 0.0, 1.0);
  var s: Surface;
  let pale = mix(vec3f(0.200, 0.090, 0.018), vec3f(0.150, 0.078, 0.026), 0.5 + 0.5 * own.y);
  let brown = mix(vec3f(0.036, 0.014, 0.005), vec3f(0.016, 0.010, 0.006), 0.5 + 0.5 * own.z);
  s.albedo = mix(pale, brown, dark) * (1.0 + 0.7 * fine.w + 0.3 * middle.w);
  // Bile stays in the hollows.
  let hollow = smoothstep(0.97, 0.80, length(p));
  s.albedo = mix(s.albedo, vec3f(0.030, 0.026, 0.006), 0.5 * hollow);
  s.smooth_normal = normalize(in.normal);
  let rough = turn * (middle.xyz * 0.09 + fine.xyz * 0.16);
  s.normal = normalize(s.smooth_normal - rough);
  s.film_normal = normalize(s.smooth_normal - 0.6 * rough);
  s.roughness = 0.5;
  s.film = 0.75;
  s.film_roughness = 0.17 + 0.05 * fine.w;
  s.reflectance = 0.04;
  s.scatter = vec3f(0.22, 0.12, 0.05);
  s.metal = 0.0;
  // Tissue hides half of the cavity from the underside.
  s.ambient = 0.60 + 0.40 * dot(s.smooth_normal, stains.up.xyz);
  return s;
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let footprint = length(fwidth(in.part_cm));
  if (in.part >= 32u) {
    return vec4f(through_haze(shade(gallstone(in, 0.01 * footprint), in.world), in.world), depth_of(in.world));
  }
  let look = looks[in.look & 15u];
  let p = in.part_cm;
  // The surface is brushed along the shaft, and worn in places.
  let brushed = noise(p * vec3f(26.0, 26.0, 1.3)) * (1.0 - smoothstep(0.02, 0.06, footprint)) * look.lobule.w;
  let worn = noise(p * look.low.w);
  var s: Surface;
  s.albedo = mix(look.low.rgb, look.high.rgb, clamp(0.5 + 0.6 * worn.w, 0.0, 1.0));
  s.smooth_normal = normalize(in.normal);
  s.normal = normalize(s.smooth_normal + vec3f(brushed.x, brushed.y, 0.0) * 0.03);
  s.film_normal = s.normal;
  s.roughness = clamp(look.wet.x + 0.10 * worn.w + 0.12 * brushed.w, 0.06, 1.0);
  s.film = look.wet.y;
  s.film_roughness = look.wet.z;
  s.reflectance = look.wet.w;
  s.scatter = look.scatter.rgb;
  s.metal = look.lobule.z;
  s.ambient = 1.0;
  let soil = soiled(p, in.part, brushed.w);
  if (soil.x + soil.y + soil.z > 0.0) {
    // A thin film lets steel shine through; char is dull.
    let film = max(soil.y, soil.z);
    let under = mix(vec3f(0.16, 0.006, 0.006), vec3f(0.15, 0.13, 0.02), soil.z / max(film + soil.z, 1e-3));
    s.albedo = mix(s.albedo, under, 0.9 * film);
    s.metal *= 1.0 - 0.85 * film;
    s.film = mix(s.film, 1.0, film);
    s.film_roughness = mix(s.film_roughness, 0.10, film);
    s.albedo = mix(s.albedo, vec3f(0.014, 0.010, 0.008), 0.96 * soil.x);
    s.metal *= 1.0 - 0.97 * soil.x;
    s.reflectance = mix(s.reflectance, 0.04, max(film, soil.x));
    s.roughness = mix(s.roughness, 0.80, soil.x);
    s.film *= 1.0 - 0.8 * soil.x;
  }
  return vec4f(through_haze(shade(s, in.world), in.world), depth_of(in.world));
}
