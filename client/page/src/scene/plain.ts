// The same materials for machines that draw in software: without reflections and maps of the surface, at a third of the time.
import { type Material, MeshLambertMaterial, type MeshStandardMaterial } from 'three';

export function plain(material: Material): Material {
  const { name, color, map, vertexColors, transparent, opacity, side, alphaTest, depthWrite, flatShading, metalness = 0 } = material as MeshStandardMaterial;
  if (!color) return material;
  const made = new MeshLambertMaterial({ name, color, map: map ?? null, vertexColors, transparent, opacity, side, alphaTest, depthWrite, flatShading: flatShading ?? false });
  // Metal has only what it reflects: grey is nearer than black.
  if (metalness > 0.5) made.color.multiplyScalar(0.8);
  return made;
}
