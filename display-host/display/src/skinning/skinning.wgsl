// Skinning on the graphics device. Twin of `SkinMesh::skin`.

struct RestVertex {
  position: vec3f, look: u32,
  normal: vec3f, ambient: f32,
  spheres: vec4u,
  weights: vec4u,
}
struct SkinnedVertex { position: vec4f, normal: vec4f }
// An affine motion, as rows: x' = x + G x + t (see motion.rs).
struct Motion { x: vec4f, y: vec4f, z: vec4f }
// A capsule that presses (see press.rs).
struct Press {
  a: vec4f,     // w: radius, m
  b: vec4f,
  into: vec4f,  // w: degree of contact
}
// Jaws that hold tissue (see bite.rs).
struct Bite {
  joint: vec4f,   // w: closure
  tip: vec4f,
  across: vec4f,  // unit vector along their opening
}
struct Touch { presses: array<Press, 8>, bite: Bite }
struct Counts { skinned: u32, unused0: u32, unused1: u32, unused2: u32 }

@group(0) @binding(0) var<uniform> counts: Counts;
@group(0) @binding(1) var<storage, read> rest: array<RestVertex>;
@group(0) @binding(2) var<storage, read> motion: array<Motion>;
@group(0) @binding(3) var<storage, read_write> now: array<SkinnedVertex>;
@group(0) @binding(4) var<storage, read> ring_first: array<u32>;
@group(0) @binding(5) var<storage, read> ring: array<u32>;
@group(0) @binding(6) var<storage, read> ring_rest: array<vec2f>;
@group(0) @binding(7) var<storage, read> corner: array<u32>;
@group(0) @binding(8) var<uniform> touch: Touch;

@compute @workgroup_size(64)
fn move_vertices(@builtin(global_invocation_id) id: vec3u) {
  let i = id.x;
  if (i >= counts.skinned) { return; }
  var x = vec4f(0.0);
  var y = vec4f(0.0);
  var z = vec4f(0.0);
  for (var k = 0u; k < 4u; k++) {
    let pair = rest[i].spheres[k];
    let weight = unpack2x16unorm(rest[i].weights[k]);
    let a = motion[pair & 0xffffu];
    let b = motion[pair >> 16u];
    x += a.x * weight.x + b.x * weight.y;
    y += a.y * weight.x + b.y * weight.y;
    z += a.z * weight.x + b.z * weight.y;
  }
  let p = vec4f(rest[i].position, 1.0);
  let carried = p.xyz + vec3f(dot(x, p), dot(y, p), dot(z, p));
  let position = carried + bitten(carried);
  let n = rest[i].normal;
  let normal = normalize(n + vec3f(dot(x.xyz, n), dot(y.xyz, n), dot(z.xyz, n)));
  let around = FARTHEST * sqrt(2.0 / max(ring_rest[i].y, 1e-6));
  let push = pushed(position, normal, around);
  now[i].position = vec4f(position + push, length(push));
}

const MOUTH: f32 = 0.72;
const CORE: f32 = 0.0025;
const FADES: f32 = 0.0045;
const NARROWED: f32 = 0.2;

// Displacement of a vertex into the jaws. Twin of `bite::bitten`, which explains it.
fn bitten(at: vec3f) -> vec3f {
  let closed = touch.bite.joint.w;
  let joint = touch.bite.joint.xyz;
  let axis = touch.bite.tip.xyz - joint;
  let length2 = dot(axis, axis);
  if (closed <= 0.0 || length2 <= 1e-12) { return vec3f(0.0); }
  let share = clamp(dot(at - joint, axis) / length2, 0.0, 1.0);
  let away = length(at - joint - axis * share);
  let x = max(away - CORE, 0.0) / FADES;
  let held = closed * exp(-x * x);
  let off = at - joint - axis * MOUTH;
  let across = touch.bite.across.xyz;
  let flat_off = off - across * dot(off, across);
  let along = axis * (dot(flat_off, axis) / length2);
  return (across * dot(off, across) + along + (flat_off - along) * NARROWED) * -held;
}

const FARTHEST: f32 = 1.2;
const SHOULDER: f32 = 0.003;
const SHOULDER_PER_DEPTH: f32 = 0.35;
const STEPS: u32 = 6u;

// Displacement of a vertex by the tools. Twin of `press::pushed`, which explains it.
fn pushed(at: vec3f, normal: vec3f, around: f32) -> vec3f {
  var push = vec3f(0.0);
  var most = 0.0;
  for (var k = 0u; k < 8u; k++) {
    let press = touch.presses[k];
    let into = press.into.xyz;
    let facing = smoothstep(0.0, 0.5, -dot(normal, into)) * press.into.w;
    if (facing <= 0.0) { continue; }
    let radius = press.a.w;
    let b_is_deep = dot(press.b.xyz - press.a.xyz, into) >= 0.0;
    let deep = select(press.a.xyz, press.b.xyz, b_is_deep);
    let other = select(press.b.xyz, press.a.xyz, b_is_deep);
    let axis = (deep - other) - into * dot(deep - other, into);
    let offset = (at - other) - into * dot(at - other, into);
    let share = clamp(dot(offset, axis) / max(dot(axis, axis), 1e-12), 0.0, 1.0);
    let beside = mix(other, deep, share);
    for (var step = 0u; step < STEPS; step++) {
      let q = mix(beside, deep, f32(step) / f32(STEPS - 1u)) - at;
      let along = dot(q, into);
      let depth = along + radius;
      if (depth <= 0.0) { continue; }
      let across = max(length(q - into * along) - radius - around, 0.0);
      let x = across / (SHOULDER + SHOULDER_PER_DEPTH * depth);
      let behind = smoothstep(0.025, 0.035, depth);
      let size = depth * exp(-x * x) * (1.0 - behind) * facing;
      if (size > most) {
        most = size;
        push = into * size;
      }
    }
  }
  return push;
}

@compute @workgroup_size(64)
fn gather_normals(@builtin(global_invocation_id) id: vec3u) {
  let i = id.x;
  if (i >= counts.skinned) { return; }
  let here = now[i].position.xyz;
  var normal = vec3f(0.0);
  var lean = vec3f(0.0);
  let first = ring_first[i];
  let end = ring_first[i + 1u];
  for (var k = first; k < end; k++) {
    let t = ring[k] * 3u;
    let a = now[corner[t]].position.xyz;
    let b = now[corner[t + 1u]].position.xyz;
    let c = now[corner[t + 2u]].position.xyz;
    normal += cross(b - a, c - a);
    lean += (a - here) + (b - here) + (c - here);
  }
  let size = length(normal);
  var unit = rest[i].normal;
  var lift = 0.0;
  if (size > 1e-20) {
    unit = normal / size;
    lift = dot(lean, unit) / f32(2u * (end - first));
  }
  now[i].normal = vec4f(unit, (lift - ring_rest[i].x) * ring_rest[i].y);
}
