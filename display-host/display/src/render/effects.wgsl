// Particles of smoke, steam, sparks and drops, as discs that face the camera.

// See particles.rs.
struct Disc {
  at: vec4f,     // middle, m; w: radius, m
  colour: vec4f, // rgb; a: opacity
  look: vec4f,   // 0 puff, 1 drop, 2 spark; individual number; streak's half length over radius; 0
  along: vec4f,  // unit direction of a streak
}
@group(1) @binding(0) var<storage, read> discs: array<Disc>;

struct VertexOut {
  @builtin(position) clip: vec4f,
  @location(0) world: vec3f,
  @location(1) corner: vec2f,
  @location(2) @interpolate(flat) index: u32,
}

@vertex fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) i: u32) -> VertexOut {
  let k = vertex % 6u;
  let corner = vec2f(select(-1.0, 1.0, k == 1u || k == 2u || k == 4u), select(-1.0, 1.0, k == 2u || k == 4u || k == 5u));
  let d = discs[i];
  let to_eye = normalize(frame.camera.xyz - d.at.xyz);
  var up = frame.up.xyz;
  if (d.look.z > 0.0) { up = d.along.xyz; }
  let right = normalize(cross(up, to_eye) + vec3f(1e-6, 0.0, 0.0));
  let over = cross(to_eye, right);
  let world = d.at.xyz + (right * corner.x + over * corner.y * max(1.0, d.look.z)) * d.at.w;
  return VertexOut(frame.clip_from_world * vec4f(world, 1.0), world, corner, i);
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let d = discs[in.index];
  let r = length(in.corner);
  let to_light = frame.light.xyz - in.world;
  let d2 = dot(to_light, to_light);
  let light = frame.light.w / (d2 + 0.0001);
  if (d.look.x > 1.5) {
    // A spark is not shaded: its colour is its brightness relative to the scope's light.
    let glow = exp(-4.0 * r * r) * (1.0 - smoothstep(0.8, 1.0, r));
    let near = smoothstep(0.02, 0.05, length(frame.camera.xyz - in.world));
    return vec4f(d.colour.rgb * light, glow * near * d.colour.a);
  }
  if (d.look.x > 0.5) {
    // A drop looks like a shiny ball.
    let inside = 1.0 - smoothstep(0.85, 1.0, r);
    let to_eye = normalize(frame.camera.xyz - d.at.xyz);
    let right = normalize(cross(frame.up.xyz, to_eye));
    let over = cross(to_eye, right);
    let normal = normalize(right * in.corner.x + over * in.corner.y + to_eye * sqrt(max(1.0 - r * r, 0.0)));
    let l = to_light * inverseSqrt(d2);
    let glint = pow(max(dot(normal, normalize(l + to_eye)), 0.0), 500.0) * 0.6;
    // The drop is darker where it is thicker.
    let deep = mix(1.0, 0.45, sqrt(max(1.0 - r * r, 0.0)));
    let body = d.colour.rgb * deep * (0.25 + 0.75 * max(dot(normal, l), 0.0)) / PI;
    return vec4f((body + vec3f(glint)) * light, inside * d.colour.a);
  }
  // Noise that is fixed in the room hides the disc of a puff. The puff fades near the lens.
  let drift = vec3f(0.0, -0.35, 0.1) * frame.camera.w;
  var cloud = 0.35 + 1.3 * noise(in.world * 45.0 + drift).w;
  if (!PLAIN) { cloud += 0.8 * noise(in.world * 120.0 + 1.7 * drift).w; }
  let soft = (1.0 - r * r) * (1.0 - r * r);
  let near = smoothstep(0.006, 0.03, length(frame.camera.xyz - in.world));
  let thick = select(0.0, soft, r < 1.0) * clamp(cloud, 0.0, 1.0) * near * d.colour.a;
  return vec4f(d.colour.rgb * light / PI, clamp(thick, 0.0, 1.0));
}
