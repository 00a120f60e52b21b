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
// A dent (see dent.rs).
struct Dent {
  a: vec4f,     // w: radius, m
  b: vec4f,     // w: depth, m
  into: vec4f,
  spheres: vec4u,  // the organ's first sphere, and the first sphere after its last
}
struct Touch { count: vec4u, dents: array<Dent, 64> }
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
  let around = FARTHEST * sqrt(2.0 / max(ring_rest[i].y, 1e-6));
  let push = dented(i, carried, around);
  now[i].position = vec4f(carried + push, length(push));
}

const FARTHEST: f32 = 1.2;
const SHOULDER: f32 = 0.0015;
const SHOULDER_PER_DEPTH: f32 = 0.4;
const FADES: f32 = 0.005;
const ROUGH: f32 = 0.001;

// Displacement by the dents of vertex `i`, which the spheres have carried to `at`. Its twin
// `dent::dented` explains it.
fn dented(i: u32, at: vec3f, around: f32) -> vec3f {
  var sum = vec3f(0.0);
  var weights = 0.0;
  for (var k = 0u; k < touch.count.x; k++) {
    let size = displaced(touch.dents[k], at, around);
    if (abs(size) <= 0.0) { continue; }
    let push = touch.dents[k].into.xyz * (size * share(i, touch.dents[k].spheres));
    let weight = dot(push, push) * dot(push, push);
    sum += push * weight;
    weights += weight;
  }
  if (weights > 0.0) { return sum / weights; }
  return vec3f(0.0);
}

// Share of the weight of vertex `i` that lies on the spheres from `spheres.x` to before
// `spheres.y`.
fn share(i: u32, spheres: vec4u) -> f32 {
  var sum = 0.0;
  for (var k = 0u; k < 4u; k++) {
    let pair = rest[i].spheres[k];
    let weight = unpack2x16unorm(rest[i].weights[k]);
    let ids = vec2u(pair & 0xffffu, pair >> 16u);
    let own = (ids >= spheres.xx) & (ids < spheres.yy);
    sum += dot(weight, select(vec2f(0.0), vec2f(1.0), own));
  }
  return sum;
}

fn displaced(dent: Dent, at: vec3f, around: f32) -> f32 {
  let into = dent.into.xyz;
  let radius = dent.a.w;
  let depth = dent.b.w;
  let axis = (dent.b.xyz - dent.a.xyz) - into * dot(dent.b.xyz - dent.a.xyz, into);
  let offset = (at - dent.a.xyz) - into * dot(at - dent.a.xyz, into);
  let place = clamp(dot(offset, axis) / max(dot(axis, axis), 1e-12), 0.0, 1.0);
  let off = at - mix(dent.a.xyz, dent.b.xyz, place);
  let along = dot(off, into);
  let up = max(radius - max(depth, 0.0), 0.0);
  let half_width = sqrt(max(radius * radius - up * up, 0.0));
  let across = max(length(off - into * along) - half_width - around, 0.0);
  let x = across / (SHOULDER + SHOULDER_PER_DEPTH * abs(depth));
  if (x > 3.0) { return 0.0; }
  let below = along - (radius - depth);
  var under = max(max(depth + ROUGH, 0.0) + 0.5 * (below + ROUGH), 0.0);
  if (below >= 0.0) {
    under = depth * exp(-below / max(FADES, 2.0 * depth));
  } else if (below > -ROUGH) {
    under = depth - below;
  }
  return under * exp(-x * x);
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
