// Position, rotation, visibility and tint of each fragment, in a texture that every shader reads. Thousands of fragments need only one
// draw call per material, and moving them uploads 48 bytes per fragment.
//
//   texel 3k      x y z  scale (0: hidden)
//   texel 3k + 1  quaternion
//   texel 3k + 2  r g b  strength of the tint
import { DataTexture, FloatType, type Material, RGBAFormat, type WebGLProgramParametersWithUniforms } from 'three';

/** Number of fragments per row of the texture. */
const ROW = 256;

const DECLARATIONS = /* glsl */`
attribute float piece;
uniform highp sampler2D poses;
varying vec4 vTint;
vec4 poseTurn;
vec4 poseTexel(int k) {
  int at = int(piece + 0.5);
  return texelFetch(poses, ivec2(3 * (at % ${ROW}) + k, at / ${ROW}), 0);
}
vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
`;

export class Poses {
  readonly texture: DataTexture;
  private readonly data: Float32Array;

  constructor(readonly count: number) {
    const rows = Math.max(1, Math.ceil(count / ROW));
    this.data = new Float32Array(ROW * 3 * 4 * rows);
    for (let k = 0; k < count; ++k) {
      this.data[12 * k + 3] = 1;
      this.data[12 * k + 7] = 1;
    }
    this.texture = new DataTexture(this.data, ROW * 3, rows, RGBAFormat, FloatType);
    this.texture.needsUpdate = true;
  }

  place(k: number, x: number, y: number, z: number): void {
    this.data.set([x, y, z], 12 * k);
  }
  turn(k: number, x: number, y: number, z: number, w: number): void {
    this.data.set([x, y, z, w], 12 * k + 4);
  }
  show(k: number, visible: boolean): void {
    this.data[12 * k + 3] = visible ? 1 : 0;
  }
  tint(k: number, r: number, g: number, b: number, share: number): void {
    this.data.set([r, g, b, share], 12 * k + 8);
  }
  visible(k: number): boolean {
    return this.data[12 * k + 3] !== 0;
  }
  /** x, y, z and the quaternion. */
  get(k: number): { at: [number, number, number]; turn: [number, number, number, number] } {
    const d = this.data, o = 12 * k;
    return { at: [d[o]!, d[o + 1]!, d[o + 2]!], turn: [d[o + 4]!, d[o + 5]!, d[o + 6]!, d[o + 7]!] };
  }
  commit(): void {
    this.texture.needsUpdate = true;
  }
  dispose(): void {
    this.texture.dispose();
  }

  /** Makes a three.js material read the texture. */
  apply<M extends Material>(material: M): M {
    material.onBeforeCompile = (shader: WebGLProgramParametersWithUniforms) => {
      shader.uniforms['poses'] = { value: this.texture };
      material.userData['shader'] = shader;
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', `#include <common>\n${DECLARATIONS}`)
        .replace('void main() {', 'void main() {\nposeTurn = poseTexel(1);')
        .replace('#include <beginnormal_vertex>', `#include <beginnormal_vertex>
objectNormal = turned(poseTurn, objectNormal);
#ifdef USE_TANGENT
objectTangent = turned(poseTurn, objectTangent);
#endif`)
        .replace('#include <begin_vertex>', `vec4 poseAt = poseTexel(0);
vec3 transformed = poseAt.xyz + turned(poseTurn, poseAt.w * position);
vTint = poseTexel(2);`);
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', '#include <common>\nvarying vec4 vTint;')
        .replace('#include <color_fragment>', '#include <color_fragment>\ndiffuseColor.rgb = mix(diffuseColor.rgb, vTint.rgb, vTint.a);')
        // A selected fragment is visible even in the shade.
        .replace('#include <opaque_fragment>', 'outgoingLight = mix(outgoingLight, vTint.rgb, step(0.99, vTint.a) * 0.6);\n#include <opaque_fragment>');
    };
    // A material that was used by another answer already has its shader; only the texture changes.
    const shader = material.userData['shader'] as WebGLProgramParametersWithUniforms | undefined;
    if (shader) shader.uniforms['poses']!.value = this.texture;
    material.customProgramCacheKey = () => 'poses';
    return material;
  }
}
