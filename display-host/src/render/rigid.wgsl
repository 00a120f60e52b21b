// Instruments: rigid parts of steel, plastic and ceramic.

@group(1) @binding(0) var<uniform> world_from_part: array<mat4x4f, 32>;

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
}

@vertex fn vertex(v: VertexIn) -> VertexOut {
  let m = world_from_part[v.part & 31u];
  let world = m * vec4f(v.position, 1.0);
  var out: VertexOut;
  out.clip = frame.clip_from_world * world;
  out.world = world.xyz;
  out.normal = (m * vec4f(v.normal, 0.0)).xyz;
  out.part_cm = v.position * 100.0;
  out.look = v.look;
  return out;
}

@vertex fn cast_shadow(v: VertexIn) -> @builtin(position) vec4f {
  return frame.shadow_from_world * world_from_part[v.part & 31u] * vec4f(v.position, 1.0);
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let look = looks[in.look & 15u];
  let p = in.part_cm;
  let footprint = length(fwidth(p));
  // Brushed along the shaft, and worn where hands and tissue rub.
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
  return vec4f(through_haze(shade(s, in.world), in.world), 1.0);
}
