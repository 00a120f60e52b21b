// Organs and the cavity around them.

// 1: two octaves, for software drivers; 2: four.
override DETAIL: u32 = 2u;

struct VertexIn {
  @location(0) position: vec4f,
  @location(1) normal: vec4f,
  @location(2) rest: vec3f,
  @location(3) look: u32,
  @location(5) ambient: f32,
}
struct VertexOut {
  @builtin(position) clip: vec4f,
  @location(0) world: vec3f,
  @location(1) normal: vec3f,
  @location(2) rest_cm: vec3f,
  @location(3) @interpolate(flat) look: u32,
  @location(4) ambient_bend_pushed: vec3f,
}

@vertex fn vertex(v: VertexIn) -> VertexOut {
  var out: VertexOut;
  out.clip = frame.clip_from_world * vec4f(v.position.xyz, 1.0);
  out.world = v.position.xyz;
  out.normal = v.normal.xyz;
  out.rest_cm = v.rest * 100.0;
  out.look = v.look;
  out.ambient_bend_pushed = vec3f(v.ambient, v.normal.w, v.position.w);
  return out;
}

@vertex fn cast_shadow(@location(0) position: vec4f) -> @builtin(position) vec4f {
  return frame.shadow_from_world * vec4f(position.xyz, 1.0);
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let world_x = dpdx(in.world) * 100.0;
  let world_y = dpdy(in.world) * 100.0;
  let rest_x = dpdx(in.rest_cm);
  let rest_y = dpdy(in.rest_cm);
  let footprint = max(length(rest_x), length(rest_y));
  let look = looks[in.look & 15u];
  let p = in.rest_cm;

  let coarse = noise(p * look.low.w);
  let middle = octave(p + vec3f(3.1, 0.7, 5.3), look.high.w, footprint);
  var lobule = vec4f(0.0);
  var grain = vec4f(0.0);
  if (DETAIL >= 2u) {
    lobule = octave(p + vec3f(9.2, 4.4, 1.1), look.lobule.x, footprint);
    grain = octave(p, look.lobule.y, footprint);
  }

  var s: Surface;
  s.albedo = mix(look.low.rgb, look.high.rgb, clamp(0.5 + 0.75 * coarse.w + 0.45 * middle.w, 0.0, 1.0));
  let streak = smoothstep(0.0, 0.75, middle.w - 0.45 * coarse.w + 0.35 * lobule.w) * look.streak.w;
  s.albedo = mix(s.albedo, look.streak.rgb, streak);
  s.albedo *= 1.0 + look.scatter.w * (lobule.w + 0.5 * grain.w);

  // Fine vessels: where noise passes through zero, now here, now there.
  if (look.lobule.w > 0.0) {
    let line = octave(p + vec3f(17.3, 2.9, 8.1), look.high.w * 0.8, footprint).w + 0.15 * lobule.w;
    let there = smoothstep(-0.15, 0.35, coarse.w + 0.3 * middle.w);
    let vein = (1.0 - smoothstep(0.005, 0.040, abs(line))) * there * look.lobule.w;
    s.albedo = mix(s.albedo, vec3f(0.13, 0.016, 0.015), vein);
  }

  // Pressed skin: blood leaves it on the ridge, the pit lies in its own shade.
  let bend = in.ambient_bend_pushed.y;
  let pushed = in.ambient_bend_pushed.z;
  let pressed = smoothstep(8.0, 70.0, -bend) * smoothstep(0.0002, 0.002, pushed);
  let pit = smoothstep(0.002, 0.010, pushed);
  s.albedo *= mix(vec3f(1.0), vec3f(1.2, 1.5, 1.4), 0.6 * pressed);
  s.albedo *= mix(vec3f(1.0), vec3f(0.66, 0.48, 0.48), pit);

  s.smooth_normal = normalize(in.normal);
  let skin = sheet(world_x, world_y, rest_x, rest_y, s.smooth_normal);
  let tissue = look.slope.x * middle.xyz + look.slope.y * lobule.xyz + look.slope.z * grain.xyz;
  let wet = look.slope.w * (middle.xyz + 0.35 * lobule.xyz + 0.3 * grain.xyz);
  s.normal = normalize(s.smooth_normal - lean(skin, tissue));
  s.film_normal = normalize(s.smooth_normal - lean(skin, wet));
  s.roughness = look.wet.x;
  s.film = look.wet.y;
  s.film_roughness = look.wet.z;
  s.reflectance = look.wet.w;
  s.scatter = look.scatter.rgb;
  s.metal = 0.0;
  s.ambient = in.ambient_bend_pushed.x * hidden_by_tools(in.world, s.smooth_normal) * (1.0 - 0.7 * pit);
  return vec4f(shade(s, in.world), 1.0);
}
