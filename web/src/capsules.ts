// SPDX-License-Identifier: Apache-2.0
// Many capsules in one call: two spheres each, of two radii, with the cone that touches both. A sphere is a capsule without length.
import {
  BufferAttribute, DynamicDrawUsage, GLSL3, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, RawShaderMaterial, type ShaderMaterialParameters,
} from "three";

/** Into how many pieces a capsule is cut: around its axis, and from each pole to where the cone begins. */
export interface Detail {
  around: number;
  rings: number;
}

const kVertexShader = /* glsl */ `
precision highp float;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform mat3 normalMatrix;
in vec4 place;      // cosine and sine around the axis; 0: first end, 1: second end; where between the end's pole and the cone, 0 to 1
in vec4 end_a;      // centre and radius [mm]
in vec4 end_b;
in vec4 tint;
out vec3 normal;
out vec4 colour;
invariant gl_Position;

void main() {
  vec3 between = end_b.xyz - end_a.xyz;
  float apart = length(between);
  vec3 axis = apart > 1e-4 ? between / apart : vec3(0.0, 0.0, 1.0);
  vec3 helper = abs(axis.x) < 0.7 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
  vec3 side = normalize(cross(axis, helper));
  vec3 other = cross(axis, side);
  // Where the cone touches, the normal leans to the axis by the difference of the radii over the distance.
  float touch = asin(clamp((end_a.w - end_b.w) / max(apart, 1e-4), -1.0, 1.0));
  float pole = 1.5707963;
  float angle = place.z < 0.5 ? mix(-pole, touch, place.w) : mix(touch, pole, place.w);
  vec3 outward = cos(angle) * (place.x * side + place.y * other) + sin(angle) * axis;
  vec4 end = place.z < 0.5 ? end_a : end_b;
  normal = normalMatrix * outward;
  colour = tint;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(end.xyz + end.w * outward, 1.0));
}
`;

const kFragmentShader = /* glsl */ `
precision highp float;
in vec3 normal;
in vec4 colour;
uniform float flatness;   // 1: the colour itself; 0: shaded
out vec4 pixel_colour;
void main() {
  float facing = max(normalize(normal).z, 0.0);
  pixel_colour = vec4(colour.rgb * mix(0.35 + 0.65 * facing, 1.0, flatness), colour.a);
}
`;

function unitGeometry({ around, rings }: Detail): InstancedBufferGeometry {
  const places: number[] = [];
  for (let ring = 0; ring < 2 * (rings + 1); ++ring) {
    const isSecond = ring > rings;
    const between = (ring - (isSecond ? rings + 1 : 0)) / rings;
    for (let step = 0; step < around; ++step) {
      const angle = (2 * Math.PI * step) / around;
      places.push(Math.cos(angle), Math.sin(angle), isSecond ? 1 : 0, between);
    }
  }
  const triangles: number[] = [];
  for (let ring = 0; ring < 2 * rings + 1; ++ring) {
    for (let step = 0; step < around; ++step) {
      const a = ring * around + step;
      const b = ring * around + ((step + 1) % around);
      triangles.push(a, b, a + around, b, b + around, a + around);
    }
  }
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute("place", new BufferAttribute(new Float32Array(places), 4));
  geometry.setIndex(triangles);
  return geometry;
}

/** A batch that is filled anew for each frame; its memory grows and stays. */
export class Capsules {
  readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;
  #geometry: InstancedBufferGeometry;
  #count = 0;
  #capacity = 0;
  #a!: InstancedBufferAttribute;
  #b!: InstancedBufferAttribute;
  #tint!: InstancedBufferAttribute;

  /** `flatness`: 0 is shaded as a solid, 1 is the plain colour. */
  constructor(detail: Detail, parameters: ShaderMaterialParameters, flatness = 0) {
    this.#geometry = unitGeometry(detail);
    const material = new RawShaderMaterial({
      glslVersion: GLSL3, vertexShader: kVertexShader, fragmentShader: kFragmentShader,
      uniforms: { flatness: { value: flatness } }, ...parameters,
    });
    this.mesh = new Mesh(this.#geometry, material);
    this.mesh.frustumCulled = false;
    this.#grow(256);
    this.#geometry.instanceCount = 0;
  }

  /** A second mesh of the same capsules, drawn in another way. */
  meshWith(parameters: ShaderMaterialParameters): Mesh {
    const material = this.mesh.material.clone();
    material.setValues(parameters);
    const mesh = new Mesh(this.#geometry, material);
    mesh.frustumCulled = false;
    return mesh;
  }

  begin(): void {
    this.#count = 0;
  }

  /** Adds a capsule: ends [mm], radii [mm], colour and opacity from 0 to 1. */
  add(ax: number, ay: number, az: number, ar: number, bx: number, by: number, bz: number, br: number,
      rgb: readonly [number, number, number], opacity: number): void {
    if (this.#count === this.#capacity) this.#grow(2 * this.#capacity);
    this.#a.setXYZW(this.#count, ax, ay, az, ar);
    this.#b.setXYZW(this.#count, bx, by, bz, br);
    this.#tint.setXYZW(this.#count, rgb[0], rgb[1], rgb[2], opacity);
    ++this.#count;
  }

  end(): void {
    this.#geometry.instanceCount = this.#count;
    for (const attribute of [this.#a, this.#b, this.#tint]) attribute.needsUpdate = true;
  }

  #grow(capacity: number): void {
    const grown = (name: string, old: InstancedBufferAttribute | undefined): InstancedBufferAttribute => {
      const attribute = new InstancedBufferAttribute(new Float32Array(4 * capacity), 4);
      attribute.setUsage(DynamicDrawUsage);
      if (old) attribute.array.set(old.array);
      this.#geometry.setAttribute(name, attribute);
      return attribute;
    };
    this.#a = grown("end_a", this.#a);
    this.#b = grown("end_b", this.#b);
    this.#tint = grown("tint", this.#tint);
    this.#capacity = capacity;
  }
}
