// Uniforms of every drawing pass. Lengths in m unless they say cm.

struct Frame {
  clip_from_world: mat4x4f,
  shadow_from_world: mat4x4f,
  camera: vec4f,        // position; w: time, s
  forward: vec4f,       // unit; w: tangent of half the source picture's height
  up: vec4f,            // unit; w: width over height
  light: vec4f,         // position; w: strength, so that irradiance is strength / distance²
  light_axis: vec4f,    // unit; w: cosine at the cone's edge
  scope: vec4f,         // half angle at the circle's edge (rad), circle's radius (half heights), width, height (px)
  adapt: vec4f,         // step of the exposure in this frame, as a share, key, exposure min, max
  film: vec4f,          // grain; of the front lens: fog, soot; haze, 1/m
  wear: vec4f,          // of the instrument's working end: shares under char, blood, bile; focus, m, or 0: everything sharp
  counts: vec4u,        // capsules, frame number, picture's pixels along a side of one of the light, gallstones
  capsules: array<vec4f, 8>, // ends of four capsules; w of the first end: radius
  stones: array<vec4f, 12>,  // centres of the nearest gallstones; w: radius
}

const PI = 3.14159265;

// Distance of a point in front of the camera, m. The light picture stores it as alpha, for the
// focus; 0: always sharp.
fn depth_of(world: vec3f) -> f32 {
  return dot(world - frame.camera.xyz, frame.forward.xyz);
}

fn full_screen(index: u32) -> vec4f {
  return vec4f(f32(i32(index & 1u) * 4 - 1), f32(i32(index >> 1u) * 4 - 1), 0.0, 1.0);
}

// Hash of a grid point: three numbers from -1 to 1 (Jarzynski and Olano 2020, pcg3d).
fn hash3(at: vec3u) -> vec3f {
  var v = at * 1664525u + 1013904223u;
  v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
  v ^= v >> vec3u(16u);
  v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
  return vec3f(v >> vec3u(8u)) * (2.0 / 16777216.0) - 1.0;
}
