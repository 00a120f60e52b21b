// View of the model inside the organs: spheres and springs, with the skin as glass around them.

// A sphere: drawn centre and radius (m), colour.
struct Ball { at: vec4f, colour: vec4f }
@group(1) @binding(0) var<storage, read> balls: array<Ball>;
@group(1) @binding(1) var<storage, read> springs: array<vec2u>;

struct Solid {
  @builtin(position) clip: vec4f,
  @location(0) world: vec3f,
  @location(1) normal: vec3f,
  @location(2) @interpolate(flat) colour: vec3f,
}

// Cells around a ball and from pole to pole, six corners each (`inside.rs` draws as many).
const AROUND: u32 = 14u;
const RINGS: u32 = 7u;
const HALF_SPRING_M: f32 = 0.00035;

// Corner of a vertex in its cell: two triangles, counter-clockwise.
fn corner(vertex: u32) -> vec2u {
  let k = vertex % 6u;
  return vec2u(select(0u, 1u, k == 1u || k == 2u || k == 4u), select(0u, 1u, k == 2u || k == 4u || k == 5u));
}

@vertex fn ball(@builtin(vertex_index) vertex: u32, @builtin(instance_index) i: u32) -> Solid {
  let cell = vertex / 6u;
  let at = vec2u(cell % AROUND, cell / AROUND) + corner(vertex);
  let turn = f32(at.x) / f32(AROUND) * 2.0 * PI;
  let tilt = f32(at.y) / f32(RINGS) * PI;
  let normal = vec3f(sin(tilt) * cos(turn), cos(tilt), sin(tilt) * sin(turn));
  let world = balls[i].at.xyz + normal * balls[i].at.w;
  return Solid(frame.clip_from_world * vec4f(world, 1.0), world, normal, balls[i].colour.rgb);
}

// A spring is a ribbon that faces the camera.
@vertex fn spring(@builtin(vertex_index) vertex: u32, @builtin(instance_index) i: u32) -> Solid {
  let a = balls[springs[i].x].at.xyz;
  let b = balls[springs[i].y].at.xyz;
  let end = corner(vertex);
  let at = mix(a, b, f32(end.x));
  let to_eye = frame.camera.xyz - at;
  let across = cross(b - a, to_eye);
  let side = across / max(length(across), 1e-9) * HALF_SPRING_M * (2.0 * f32(end.y) - 1.0);
  let world = at + side;
  return Solid(frame.clip_from_world * vec4f(world, 1.0), world, normalize(to_eye), vec3f(0.25, 0.62, 0.32));
}

fn irradiance(world: vec3f) -> f32 {
  let to_light = frame.light.xyz - world;
  return frame.light.w / (dot(to_light, to_light) + 0.0001);
}

@fragment fn solid(in: Solid) -> @location(0) vec4f {
  let light = normalize(frame.light.xyz - in.world);
  let facing = max(dot(normalize(in.normal), light), 0.0);
  return vec4f(in.colour * (0.12 + 0.88 * facing) * irradiance(in.world) / PI, 0.0);
}

struct GlassIn {
  @location(0) position: vec4f,
  @location(1) normal: vec4f,
  @location(3) look: u32,
}
struct Glass {
  @builtin(position) clip: vec4f,
  @location(0) world: vec3f,
  @location(1) normal: vec3f,
  @location(2) @interpolate(flat) look: u32,
}

@vertex fn glass(v: GlassIn) -> Glass {
  return Glass(frame.clip_from_world * vec4f(v.position.xyz, 1.0), v.position.xyz, v.normal.xyz, v.look);
}

@fragment fn shine(in: Glass) -> @location(0) vec4f {
  let view = normalize(frame.camera.xyz - in.world);
  let normal = normalize(in.normal);
  let facing = clamp(dot(normal, view), 0.0, 1.0);
  let tint = looks[in.look & 15u].high.rgb * 1.6;
  let glint = pow(max(dot(normal, normalize(view + normalize(frame.light.xyz - in.world))), 0.0), 90.0);
  let opaque = mix(0.75, 0.10, smoothstep(0.0, 0.75, facing)) + 0.25 * glint;
  let light = irradiance(in.world) / PI;
  return vec4f((tint * (0.35 + 0.65 * facing) + vec3f(glint)) * light, opaque);
}
