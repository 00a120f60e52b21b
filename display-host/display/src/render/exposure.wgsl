// Automatic exposure, by the mean logarithm of the picture's light, with more weight in the middle.

struct Exposure { value: f32, unused0: f32, unused1: f32, unused2: f32 }

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> exposure: Exposure;

const SIDE = 48u;
var<workgroup> sums: array<vec2f, 64>;

@compute @workgroup_size(64)
fn measure(@builtin(local_invocation_index) lane: u32) {
  let size = vec2f(textureDimensions(picture));
  var sum = vec2f(0.0);
  for (var i = lane; i < SIDE * SIDE; i += 64u) {
    // Places in the square in the middle of the circle are measured.
    let at = (vec2f(f32(i % SIDE), f32(i / SIDE)) + 0.5) / f32(SIDE) * 2.0 - 1.0;
    let ndc = at * 0.85 / vec2f(frame.up.w, 1.0);
    let c = textureLoad(picture, vec2i((ndc * 0.5 + 0.5) * size), 0).rgb;
    let light = dot(c, vec3f(0.2126, 0.7152, 0.0722));
    // Empty places are not measured.
    let weight = select(0.0, exp(-2.0 * dot(at, at)), light > 1e-6);
    sum += vec2f(log2(clamp(light, 1e-4, 16.0)), 1.0) * weight;
  }
  sums[lane] = sum;
  workgroupBarrier();
  if (lane == 0u) {
    var total = vec2f(0.0);
    for (var i = 0u; i < 64u; i++) { total += sums[i]; }
    let mean = exp2(total.x / max(total.y, 1e-6));
    let wanted = clamp(frame.adapt.y / mean, frame.adapt.z, frame.adapt.w);
    exposure.value = mix(exposure.value, wanted, frame.adapt.x);
  }
}
