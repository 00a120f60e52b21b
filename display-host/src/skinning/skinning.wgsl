// Paper Eq. 9–12 on the graphics device. Twin of `SkinMesh::skin`.

struct RestVertex {
  position: vec3f, look: u32,
  normal: vec3f, ambient: f32,
  spheres: vec4u,
  weights: vec4u,
}
struct SkinnedVertex { position: vec4f, normal: vec4f }
struct Counts { skinned: u32, unused0: u32, unused1: u32, unused2: u32 }

@group(0) @binding(0) var<uniform> counts: Counts;
@group(0) @binding(1) var<storage, read> rest: array<RestVertex>;
@group(0) @binding(2) var<storage, read> displacement: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> now: array<SkinnedVertex>;
@group(0) @binding(4) var<storage, read> ring_first: array<u32>;
@group(0) @binding(5) var<storage, read> ring: array<u32>;
@group(0) @binding(6) var<storage, read> ring_rest: array<vec2f>;
@group(0) @binding(7) var<storage, read> corner: array<u32>;

@compute @workgroup_size(64)
fn move_vertices(@builtin(global_invocation_id) id: vec3u) {
  let i = id.x;
  if (i >= counts.skinned) { return; }
  var moved = vec3f(0.0);
  for (var k = 0u; k < 4u; k++) {
    let pair = rest[i].spheres[k];
    let weight = unpack2x16unorm(rest[i].weights[k]);
    moved += displacement[pair & 0xffffu].xyz * weight.x;
    moved += displacement[pair >> 16u].xyz * weight.y;
  }
  now[i].position = vec4f(rest[i].position + moved, 0.0);
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
