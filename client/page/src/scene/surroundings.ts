// A studio that is visible only in reflections: a bright ceiling, a window, dark walls.
import { BackSide, BoxGeometry, Mesh, MeshBasicMaterial, Scene } from 'three';

export function surroundings(): Scene {
  const scene = new Scene();
  const box = (color: number, size: readonly [number, number, number], at: readonly [number, number, number], inside = false) => {
    const mesh = new Mesh(new BoxGeometry(...size), new MeshBasicMaterial({ color, ...(inside ? { side: BackSide } : {}) }));
    mesh.material.color.multiplyScalar(inside ? 1 : 6);
    mesh.position.set(...at);
    scene.add(mesh);
  };
  box(0x8f959c, [20, 12, 20], [0, 3, 0], true);
  box(0xffffff, [9, 0.1, 9], [0, 8.8, 0]);
  box(0xdfe9ff, [0.1, 5, 7], [-9.8, 3, 0]);
  box(0xfff1dd, [5, 3, 0.1], [3, 3, 9.8]);
  return scene;
}
