// Glare. One pass takes the light that is brighter than the screen, halves its size and blurs it.
// Further passes halve and blur it again.

// Exposed light below this causes no glare. The threshold is 0 in the further passes.
override THRESHOLD: f32 = 0.0;
struct Exposure { value: f32, unused0: f32, unused1: f32, unused2: f32 }

@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var linear: sampler;
@group(0) @binding(2) var<storage, read> exposure: Exposure;

struct VertexOut { @builtin(position) clip: vec4f, @location(0) uv: vec2f }

@vertex fn vertex(@builtin(vertex_index) index: u32) -> VertexOut {
  let at = vec2f(f32(i32(index & 1u) * 4 - 1), f32(i32(index >> 1u) * 4 - 1));
  return VertexOut(vec4f(at, 0.0, 1.0), at * vec2f(0.5, -0.5) + 0.5);
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let texel = 1.0 / vec2f(textureDimensions(source));
  let gain = select(1.0, exposure.value, THRESHOLD > 0.0);
  var sum = vec3f(0.0);
  for (var y = -1; y <= 1; y++) {
    for (var x = -1; x <= 1; x++) {
      let weight = (2.0 - f32(abs(x))) * (2.0 - f32(abs(y))) / 16.0;
      let c = textureSampleLevel(source, linear, in.uv + vec2f(f32(x), f32(y)) * texel * 1.5, 0.0).rgb;
      sum += clamp(c * gain - THRESHOLD, vec3f(0.0), vec3f(6.0)) * weight;
    }
  }
  return vec4f(sum, 1.0);
}
