// Simpler materials for software rendering, without reflections and surface maps. They draw in a third of the time.
import { type Material, MeshLambertMaterial, type MeshStandardMaterial } from 'three';

export function plain(material: Material): Material {
  const { name, color, map, vertexColors, transparent, opacity, side, alphaTest, depthWrite, flatShading, metalness = 0 } = material as MeshStandardMaterial;
  if (!color) return material;
  const made = new MeshLambertMaterial({ name, color, map: map ?? null, vertexColors, transparent, opacity, side, alphaTest, depthWrite, flatShading: flatShading ?? false });
  // Metal shows only reflections. Without them it would be black, so a grey is closer to its real appearance.
  if (metalness > 0.5) made.color.multiplyScalar(0.8);
  return made;
}
