/* SPDX-License-Identifier: Apache-2.0 */
/*
 * surface.js: all frames of a texture as one WebGL2 texture array, drawn on a plane or a sphere. One
 * triangle covers the canvas; each pixel of it finds its place on the shape by itself, so that picking
 * here, in scripts, is the same few lines of arithmetic.
 */
"use strict";
(() => {
  const VERTEX = `#version 300 es
    void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`;

  const ENCODE = `
    vec3 encode(vec3 c) { return mix(12.92 * c, 1.055 * pow(max(c, 1e-7), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }`;

  const DRAW = `#version 300 es
    precision highp float; precision highp int; precision highp sampler2DArray;
    uniform sampler2DArray frames;
    uniform float layer, gain, scale, radius;
    uniform vec2 canvas, centre, size, turn, repeat, mark;
    uniform bool sphere;
    out vec4 colour;
    ${ENCODE}
    void main() {
      vec2 at = vec2(gl_FragCoord.x, canvas.y - gl_FragCoord.y) - 0.5 * canvas;
      vec2 uv; vec2 dx; vec2 dy; float shade = 1.0;
      if (sphere) {
        vec2 p = at / radius;
        float r2 = dot(p, p);
        vec3 n = vec3(p.x, -p.y, sqrt(max(1.0 - r2, 0.0)));
        n.yz = mat2(cos(turn.y), sin(turn.y), -sin(turn.y), cos(turn.y)) * n.yz;
        float v = 0.5 - asin(clamp(n.y, -1.0, 1.0)) / 3.14159265;
        float u = atan(n.x, n.z), w = atan(-n.x, -n.z) + 3.14159265;
        float uu = fwidth(u) <= fwidth(w) + 1e-5 ? u : w;
        uv = repeat * vec2((uu + turn.x) / 6.2831853, v);
        dx = dFdx(uv); dy = dFdy(uv);
        shade = 0.45 + 0.55 * sqrt(max(1.0 - r2, 0.0));
        if (r2 > 1.0) { colour = vec4(0.0); return; }
      } else {
        uv = (centre + at / scale) / size;
        dx = dFdx(uv); dy = dFdy(uv);
        if (uv != clamp(uv, 0.0, 1.0)) { colour = vec4(0.0); return; }
      }
      vec2 lod_x = dx * size, lod_y = dy * size;
      float px = sqrt(max(dot(lod_x, lod_x), dot(lod_y, lod_y)));
      vec3 light;
      if (px < 0.5)
        light = texelFetch(frames, ivec3(ivec2(min(fract(uv) * size, size - 1.0)), int(layer)), 0).rgb;
      else
        light = textureGrad(frames, vec3(uv, layer), dx, dy).rgb;
      colour = vec4(encode(clamp(light * gain * shade, 0.0, 1.0)), 1.0);
      if (mark.x >= 0.0 && 16.0 * px < min(size.x, size.y)) {
        vec2 d = abs(mod(uv * size - mark - 0.5 + 0.5 * size, size) - 0.5 * size);
        float far = max(d.x, d.y), inner = max(0.5, 5.0 * px);
        if (far > inner && far < inner + 1.5 * px) colour = vec4(1.0, 1.0, 1.0, 1.0);
        else if (far > inner && far < inner + 3.0 * px) colour = vec4(0.0, 0.0, 0.0, 1.0);
      }
    }`;

  /* One pixel of every frame, as stored: frame i at (i, 0). */
  const LIFE = `#version 300 es
    precision highp float; precision highp int; precision highp sampler2DArray;
    uniform sampler2DArray frames;
    uniform ivec2 place;
    out vec4 colour;
    ${ENCODE}
    void main() { colour = vec4(encode(texelFetch(frames, ivec3(place, int(gl_FragCoord.x)), 0).rgb), 1.0); }`;

  function program(gl, fragment) {
    const p = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(p, shader);
    }
    gl.linkProgram(p);
    if (!gl.getProgramParameter(p, gl.LINK_STATUS))
      throw new Error(gl.getProgramInfoLog(p) || "a shader cannot be used");
    const at = {};
    for (let i = 0; i < gl.getProgramParameter(p, gl.ACTIVE_UNIFORMS); i++) {
      const name = gl.getActiveUniform(p, i).name;
      at[name] = gl.getUniformLocation(p, name);
    }
    return { p, at };
  }

  /* Canvas pixels: at zoom 1 a little less than half of the canvas's shorter side. */
  function sphereRadius(view, canvas) {
    return 0.46 * Math.min(canvas.width, canvas.height) * view.zoom;
  }

  /* Where a point of the canvas (in its pixels) lies on the shape: texture pixels, or null beside it. */
  function pick(view, width, height, canvas, x, y) {
    const ax = x - canvas.width / 2, ay = y - canvas.height / 2;
    let u, v;
    if (view.shape === "sphere") {
      const r = sphereRadius(view, canvas);
      const px = ax / r, py = -ay / r, r2 = px * px + py * py;
      if (r2 > 1)
        return null;
      const z = Math.sqrt(1 - r2), c = Math.cos(view.pitch), s = Math.sin(view.pitch);
      const ny = c * py - s * z, nz = s * py + c * z;
      u = repeats(width, height) * (Math.atan2(px, nz) + view.yaw) / (2 * Math.PI);
      v = 0.5 - Math.asin(Math.max(-1, Math.min(1, ny))) / Math.PI;
      u -= Math.floor(u);
    } else {
      const scale = planeScale(view, width, height, canvas);
      u = (view.x + ax / scale) / width;
      v = (view.y + ay / scale) / height;
    }
    if (u < 0 || v < 0 || u > 1 || v > 1)
      return null;
    return { x: Math.min(width - 1, Math.floor(u * width)), y: Math.min(height - 1, Math.floor(v * height)) };
  }

  /* How often the texture goes around the sphere so that its pixels stay about square at the equator. */
  function repeats(width, height) {
    return Math.max(1, Math.round(2 * height / width));
  }

  /* Canvas pixels per texture pixel. */
  function planeScale(view, width, height, canvas) {
    return view.zoom * Math.min(canvas.width / width, canvas.height / height);
  }

  class Surface {
    /* null where there is no WebGL2, or the frames are more than it takes. */
    static create(canvas, width, height, n) {
      const gl = canvas.getContext("webgl2", { alpha: true, premultipliedAlpha: false, antialias: false });
      if (!gl || n > gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) ||
          Math.max(width, height) > gl.getParameter(gl.MAX_TEXTURE_SIZE))
        return null;
      try {
        return new Surface(gl, width, height, n);
      } catch (error) {
        console.warn(String(error));
        return null;
      }
    }

    constructor(gl, width, height, n) {
      Object.assign(this, { gl, width, height, n, shapes: ["plane", "sphere"] });
      this.drawing = program(gl, DRAW);
      this.reading = program(gl, LIFE);
      this.texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
      gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1 + Math.floor(Math.log2(Math.max(width, height))), gl.SRGB8_ALPHA8,
        width, height, n);
      if (gl.getError() !== gl.NO_ERROR)
        throw new Error("the graphics card has no room for the frames");
      const set = (name, value) => gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl[name], gl[value]);
      set("TEXTURE_MIN_FILTER", "LINEAR_MIPMAP_LINEAR");
      set("TEXTURE_MAG_FILTER", "LINEAR");
      set("TEXTURE_WRAP_S", "REPEAT");
      set("TEXTURE_WRAP_T", "CLAMP_TO_EDGE");
    }

    async load(i, blob) {
      const { gl } = this;
      const bitmap = await createImageBitmap(blob, { premultiplyAlpha: "none", colorSpaceConversion: "none" });
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, i, this.width, this.height, 1, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
      bitmap.close();
    }

    loaded() {
      this.gl.generateMipmap(this.gl.TEXTURE_2D_ARRAY);
    }

    end() {
      this.gl.getExtension("WEBGL_lose_context")?.loseContext();
    }

    draw(view) {
      const { gl, drawing: { p, at } } = this, canvas = gl.canvas;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.useProgram(p);
      gl.uniform1f(at.layer, view.frame);
      gl.uniform1f(at.gain, view.gain);
      gl.uniform1f(at.scale, planeScale(view, this.width, this.height, canvas));
      gl.uniform1f(at.radius, sphereRadius(view, canvas));
      gl.uniform2f(at.canvas, canvas.width, canvas.height);
      gl.uniform2f(at.centre, view.x, view.y);
      gl.uniform2f(at.size, this.width, this.height);
      gl.uniform2f(at.turn, view.yaw, view.pitch);
      gl.uniform2f(at.repeat, repeats(this.width, this.height), 1);
      gl.uniform2f(at.mark, view.mark ? view.mark.x : -1, view.mark ? view.mark.y : -1);
      gl.uniform1i(at.sphere, view.shape === "sphere" ? 1 : 0);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    /* The display codes of one pixel in every frame: n x RGBA. */
    async life(x, y) {
      const { gl, n, reading: { p, at } } = this;
      const target = gl.createFramebuffer(), row = gl.createRenderbuffer(), codes = new Uint8Array(n * 4);
      gl.bindRenderbuffer(gl.RENDERBUFFER, row);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA8, n, 1);
      gl.bindFramebuffer(gl.FRAMEBUFFER, target);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, row);
      gl.viewport(0, 0, n, 1);
      gl.useProgram(p);
      gl.uniform2i(at.place, x, y);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
      gl.readPixels(0, 0, n, 1, gl.RGBA, gl.UNSIGNED_BYTE, codes);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.deleteFramebuffer(target);
      gl.deleteRenderbuffer(row);
      return codes;
    }
  }

  globalThis.ttfSurface = { Surface, pick, planeScale, sphereRadius };
})();
