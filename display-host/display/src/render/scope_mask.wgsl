// Saves the shading outside the scope's circle. Before anything else is drawn, it writes the
// nearest depth there, which is 1, because depth is reversed.

@group(0) @binding(0) var<uniform> frame: Frame;

struct VertexOut { @builtin(position) clip: vec4f, @location(0) ndc: vec2f }

@vertex fn vertex(@builtin(vertex_index) index: u32) -> VertexOut {
  let at = full_screen(index);
  return VertexOut(vec4f(at.xy, 1.0, 1.0), at.xy);
}

@fragment fn fragment(in: VertexOut) -> @location(0) vec4f {
  let edge = tan(frame.scope.x) / frame.forward.w + 0.02;
  if (length(in.ndc * vec2f(frame.up.w, 1.0)) < edge) { discard; }
  return vec4f(0.0, 0.0, 0.0, 1.0);
}
