// An answer's materials for three.js: core glTF 2.0, and the extensions for glass and lamps. You can also pass your own materials, in
// the order of the file: first the mesh's materials, then those of the cuts.
import {
  ClampToEdgeWrapping, Color, DoubleSide, FrontSide, LinearFilter, LinearMipmapLinearFilter, LinearMipmapNearestFilter, type Material,
  MeshBasicMaterial, MeshPhysicalMaterial, MirroredRepeatWrapping, NearestFilter, NearestMipmapLinearFilter, NearestMipmapNearestFilter,
  RepeatWrapping, SRGBColorSpace, Texture,
} from 'three';
import type { Answer } from '../answer.js';
import type { Glb } from '../glb.js';

const WRAP: Record<number, Texture['wrapS']> = { 33071: ClampToEdgeWrapping, 33648: MirroredRepeatWrapping, 10497: RepeatWrapping };
const FILTER: Record<number, Texture['minFilter']> = {
  9728: NearestFilter, 9729: LinearFilter, 9984: NearestMipmapNearestFilter, 9985: LinearMipmapNearestFilter,
  9986: NearestMipmapLinearFilter, 9987: LinearMipmapLinearFilter,
};

/** Returns the materials of an answer. Images are decoded if the platform has createImageBitmap(); otherwise surfaces have plain
 * colours. All answers for the same mesh can share the materials if their cut materials are the same. */
export async function materialsOf(answer: Answer): Promise<Material[]> {
  const glb = answer.document, textures = new Textures(glb);
  const primitives = (glb.json.meshes ?? []).flatMap(mesh => mesh.primitives);
  const having = (name: string) => new Set(primitives.filter(({ attributes }) => name in attributes).map(({ material }) => material));
  const colors = having('COLOR_0'), tangents = having('TANGENT');
  return Promise.all((glb.json.materials ?? []).map((source, k) =>
    materialOf(source, { colors: colors.has(k), tangents: tangents.has(k) }, textures)));
}

/** Returns the glTF default material, for primitives without a material. */
export const defaultMaterial = (): Material => new MeshPhysicalMaterial({ color: 0xffffff, metalness: 1, roughness: 1 });

async function materialOf(source: any, surface: { colors: boolean; tangents: boolean }, textures: Textures): Promise<Material> {
  const pbr = source.pbrMetallicRoughness ?? {}, [r, g, b, a] = pbr.baseColorFactor ?? [1, 1, 1, 1], extensions = source.extensions ?? {};
  const common = {
    name: source.name ?? '', color: new Color(r, g, b), opacity: source.alphaMode === 'BLEND' ? a : 1, vertexColors: surface.colors,
    transparent: source.alphaMode === 'BLEND', depthWrite: source.alphaMode !== 'BLEND', side: source.doubleSided ? DoubleSide : FrontSide,
    alphaTest: source.alphaMode === 'MASK' ? source.alphaCutoff ?? 0.5 : 0, map: await textures.get(pbr.baseColorTexture, true),
  };
  if (extensions.KHR_materials_unlit) return new MeshBasicMaterial(common);
  const packed = await textures.get(pbr.metallicRoughnessTexture), normal = await textures.get(source.normalTexture);
  const material = new MeshPhysicalMaterial({
    ...common, metalness: pbr.metallicFactor ?? 1, roughness: pbr.roughnessFactor ?? 1, metalnessMap: packed, roughnessMap: packed,
    normalMap: normal, aoMap: await textures.get(source.occlusionTexture), emissiveMap: await textures.get(source.emissiveTexture, true),
    emissive: new Color(...((source.emissiveFactor ?? [0, 0, 0]) as [number, number, number])),
    emissiveIntensity: extensions.KHR_materials_emissive_strength?.emissiveStrength ?? 1,
    ior: extensions.KHR_materials_ior?.ior ?? 1.5, transmission: extensions.KHR_materials_transmission?.transmissionFactor ?? 0,
    aoMapIntensity: source.occlusionTexture?.strength ?? 1,
  });
  const bump = source.normalTexture?.scale ?? 1;
  material.normalScale.set(bump, surface.tangents ? bump : -bump);  // if three.js derives the tangents, v points upwards
  return material;
}

class Textures {
  private readonly images = new Map<number, Promise<ImageBitmap | null>>();
  constructor(private readonly glb: Glb) {}

  async get(info: { index: number; texCoord?: number; extensions?: any } | undefined, color = false): Promise<Texture | null> {
    const source = info && this.glb.json.textures?.[info.index];
    if (!source) return null;
    const image = await this.image(source.source ?? -1);
    if (!image) return null;
    const texture = new Texture(image), sampler = this.glb.json.samplers?.[source.sampler ?? -1] ?? {};
    texture.flipY = false;
    texture.channel = info.texCoord ?? 0;
    texture.wrapS = WRAP[sampler.wrapS] ?? RepeatWrapping;
    texture.wrapT = WRAP[sampler.wrapT] ?? RepeatWrapping;
    texture.minFilter = FILTER[sampler.minFilter] ?? LinearMipmapLinearFilter;
    texture.magFilter = sampler.magFilter === 9728 ? NearestFilter : LinearFilter;
    if (color) texture.colorSpace = SRGBColorSpace;
    const moved = info.extensions?.KHR_texture_transform;
    if (moved) {
      texture.offset.set(...((moved.offset ?? [0, 0]) as [number, number]));
      texture.repeat.set(...((moved.scale ?? [1, 1]) as [number, number]));
      texture.rotation = moved.rotation ?? 0;
      texture.channel = moved.texCoord ?? texture.channel;
    }
    texture.needsUpdate = true;
    return texture;
  }

  /** Decodes an image from a Blob, because a page's policy may forbid object URLs. Returns null if the image cannot be decoded. */
  private image(index: number): Promise<ImageBitmap | null> {
    let image = this.images.get(index);
    if (!image) {
      const file = this.glb.image(index);
      const asStored: ImageBitmapOptions = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' };
      image = file && typeof createImageBitmap === 'function'
        ? createImageBitmap(new Blob([file.bytes as BlobPart], { type: file.type }), asStored).catch(() => null)
        : Promise.resolve(null);
      this.images.set(index, image);
    }
    return image;
  }
}
