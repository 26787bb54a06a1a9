// How clay answers light: six materials seen on a ball, and lights in the scene. Colours are display-linear.
const vec3 kKey = vec3(1.0, 0.93, 0.82) * 1.55;
const vec3 kFill = vec3(0.62, 0.78, 1.0) * 0.22;
const vec3 kSky = vec3(0.60, 0.70, 0.86) * 0.40;
const vec3 kGroundLight = vec3(0.50, 0.38, 0.30) * 0.20;

// What is known of one point of the surface.
struct Point {
  vec3 n, toEye;    // world
  vec3 albedo;
  float roughness, gloss;
  float shadow;     // key light that arrives
  float cursor;     // the part of that which the cursor leaves
  float sky;        // sky that the cursor leaves
  float hollow, ridge;
};

// n: right, up, towards the viewer.
vec3 matcap(vec3 n, vec3 base) {
  vec3 l = vec3(-0.453, 0.604, 0.656), h = normalize(l + vec3(0.0, 0.0, 1.0));
  float d = dot(n, l), nh = clamp(dot(n, h), 0.0, 1.0);
  float rim = 1.0 - clamp(n.z, 0.0, 1.0), rim2 = rim * rim;
  float low = clamp(dot(n, vec3(0.62, -0.62, 0.48)), 0.0, 1.0);
  if (kMatcap == 0) {  // clay: matt, warm in the shade
    float lit = smoothstep(-0.45, 1.05, d);
    vec3 c = base * mix(base * 0.22 + 0.03, vec3(1.10, 1.04, 0.95), lit * lit * (1.2 - 0.2 * lit));
    c += base * vec3(0.10, 0.13, 0.19) * low;
    c += pow(nh, 14.0) * 0.07;
    return c * (1.0 - 0.55 * rim2 * rim);
  }
  if (kMatcap == 1) {  // wax: deep colour, soft edge of the light, wet highlight
    float lit = smoothstep(-0.75, 0.95, d);
    vec3 deep = base * base * (1.6 - 0.6 * base);
    vec3 c = mix(deep * vec3(0.30, 0.16, 0.13), mix(deep, base, 0.35) * vec3(1.05, 0.95, 0.88), lit);
    c += deep * 0.25 * low;
    float shine = pow(nh, 90.0) * 0.55 + pow(nh, 18.0) * 0.13;
    return c * (1.0 - 0.35 * rim2) + shine + vec3(0.16, 0.10, 0.08) * rim2 * rim * clamp(0.4 + d, 0.0, 1.0);
  }
  if (kMatcap == 2) {  // porcelain: white, glazed
    float lit = smoothstep(-0.55, 0.9, d);
    vec3 c = mix(vec3(0.24, 0.27, 0.33), vec3(0.80, 0.785, 0.755), lit);
    c += vec3(0.06, 0.055, 0.05) * low;
    c *= 1.0 - 0.50 * rim2 * rim;
    float window = smoothstep(0.955, 0.975, nh) * 0.30 + pow(nh, 160.0) * 0.25;
    return c + window + vec3(0.20, 0.23, 0.28) * rim2 * rim2 * step(-0.2, n.y);
  }
  if (kMatcap == 3) {  // steel: a studio mirrored
    vec3 r = vec3(2.0 * n.z * n.xy, 2.0 * n.z * n.z - 1.0);
    float up = r.y + 0.10 * r.x;
    vec3 c = mix(vec3(0.035, 0.037, 0.042), vec3(0.30, 0.31, 0.325), smoothstep(-1.0, -0.08, up));
    c = mix(c, vec3(0.10, 0.105, 0.115), smoothstep(-0.10, 0.02, up));
    c = mix(c, vec3(0.62, 0.65, 0.70), smoothstep(0.02, 0.75, up));
    c += vec3(0.75, 0.74, 0.72) * smoothstep(0.80, 0.97, dot(r, l)) + 0.18 * smoothstep(0.70, 0.92, dot(r, vec3(0.80, 0.10, 0.59)));
    return c * (1.0 - 0.30 * rim2);
  }
  if (kMatcap == 4) {  // rubber: dark, a broad sheen, lighter edges
    float lit = smoothstep(-0.35, 1.0, d);
    vec3 c = mix(vec3(0.012, 0.013, 0.015), vec3(0.085, 0.087, 0.090), lit);
    c += vec3(0.016, 0.018, 0.022) * low;
    return c + pow(nh, 9.0) * 0.075 + vec3(0.060, 0.066, 0.075) * rim2 * rim;
  }
  vec3 seen = n * 0.5 + 0.5;  // normals as the usual picture of them
  return seen * seen * (0.2 * seen + 0.8);
}

vec3 litClay(Point p) {
  vec3 toKey = frame.keyLight.xyz;
  float nk = dot(p.n, toKey), nv = clamp(dot(p.n, p.toEye), 0.0, 1.0);
  // Clay scatters a little under its skin: light wraps around the edge, and is redder there.
  vec3 wrap = vec3(0.17, 0.10, 0.075);
  vec3 key = clamp((vec3(nk) + wrap) / (1.0 + wrap), 0.0, 1.0) * p.shadow * kKey;
  vec3 toFill = normalize(frame.cameraRight.xyz * 0.85 + frame.cameraUp.xyz * 0.1 - frame.cameraForward.xyz * 0.55);
  vec3 fill = clamp(dot(p.n, toFill) * 0.75 + 0.25, 0.0, 1.0) * kFill;
  vec3 dome = mix(kGroundLight, kSky, p.n.z * 0.5 + 0.5);
  vec3 around = fill + dome * p.sky + 0.10 * nv;  // seen from below, clay still has a lit face
  // The cursor's shadow is a cue for depth: it darkens the rest of the light a little too.
  vec3 ambient = around * (1.0 - 0.75 * p.hollow) * mix(0.62, 1.0, p.cursor);

  vec3 albedo = p.albedo * mix(vec3(1.0), vec3(0.50, 0.36, 0.32), p.hollow) * (1.0 + 0.55 * p.ridge);
  vec3 c = albedo * (key * (1.0 - 0.45 * p.hollow) + ambient);

  // A broad soft highlight, and a thin bright rim.
  vec3 h = normalize(toKey + p.toEye);
  float gloss = pow(clamp(dot(p.n, h), 0.0, 1.0), 26.0) * 0.16 * p.shadow * step(0.0, nk);
  float edge = (1.0 - nv) * (1.0 - nv);
  c += (gloss * kKey * 0.5 + edge * edge * dome * vec3(0.36, 0.29, 0.24)) * (1.0 - 0.6 * p.hollow);
  return c;
}

// Reflected part of a light from `l`: Cook-Torrance with GGX (Walter 2007), height-correlated Smith (Heitz 2014), Schlick's
// Fresnel. Times π, so that a light of 1 on a white matt face gives 1.
float glint(vec3 n, vec3 v, vec3 l, float alpha, float f0) {
  float nl = clamp(dot(n, l), 0.0, 1.0), nv = max(dot(n, v), 1e-3);
  vec3 h = normalize(v + l);
  float nh = clamp(dot(n, h), 0.0, 1.0), vh = clamp(dot(v, h), 0.0, 1.0);
  float a2 = alpha * alpha, q = nh * nh * (a2 - 1.0) + 1.0;
  float smith = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
  float k = 1.0 - vh, k2 = k * k;
  float fresnel = f0 + (1.0 - f0) * k2 * k2 * k * min(1.0, 12.0 * f0);
  return nl * (a2 / (q * q)) * 0.5 / max(smith, 1e-4) * fresnel;
}

vec3 made(Point p) {
  vec3 toKey = frame.keyLight.xyz;
  vec3 toFill = normalize(frame.cameraRight.xyz * 0.85 + frame.cameraUp.xyz * 0.1 - frame.cameraForward.xyz * 0.55);
  float nv = clamp(dot(p.n, p.toEye), 0.0, 1.0), rough = max(p.roughness, 0.07), alpha = rough * rough, f0 = 0.08 * p.gloss;
  float open = 1.0 - 0.8 * p.hollow, left = mix(0.62, 1.0, p.cursor);
  vec3 dome = mix(kGroundLight, kSky, p.n.z * 0.5 + 0.5) * p.sky * 1.15;
  vec3 key = kKey * (p.shadow * (1.0 - 0.45 * p.hollow));
  vec3 c = p.albedo * (1.0 + 0.35 * p.ridge) *
           (clamp(dot(p.n, toKey), 0.0, 1.0) * key + (clamp(dot(p.n, toFill), 0.0, 1.0) * kFill * 1.4 + dome + 0.07 * nv) * open * left);
  c += glint(p.n, p.toEye, toKey, alpha, f0) * key + glint(p.n, p.toEye, toFill, alpha, f0) * kFill * 2.0 * open;
  // The surroundings mirrored, as sharp as the surface is smooth: split sum after Karis (2013).
  vec3 r = reflect(-p.toEye, p.n);
  float soft = 0.12 + 0.88 * rough;
  vec3 mirrored = mix(kGroundLight, kSky * 1.6, smoothstep(-soft, soft, r.z)) + vec3(0.9, 0.92, 0.95) * (1.0 - rough) * smoothstep(0.55, 0.95, r.z);
  vec4 k = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a004 = min(k.x * k.x, exp2(-9.28 * nv)) * k.x + k.y;
  vec2 ab = vec2(-1.04, 1.04) * a004 + k.zw;
  c += mirrored * (f0 * ab.x + ab.y * min(1.0, 12.0 * f0)) * open * left;
  return c;
}
