// The viewport: renderer, camera, light and ground. It draws when something has changed, and not otherwise.
import {
  Color, DirectionalLight, type DirectionalLightShadow, Group, HemisphereLight, Mesh, Object3D, PCFShadowMap, PerspectiveCamera,
  PlaneGeometry, PMREMGenerator, Ray, Scene, ShadowMaterial, Spherical, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { gridOf } from './grid';
import { surroundings } from './surroundings';

/** Milliseconds between frames that are too many, and frames of them in a row until it is drawn in a cheaper way. */
const SLOW = 90, PATIENCE = 6;
/** Dots for each pixel of the page at most, while something moves: from all that the screen has to a blur that still follows the hand.
 * Below the first without shadows, which are half the time of a frame in software. What stands still has everything. */
const PACES = [2, 0.8, 0.6, 0.45] as const;
/** Milliseconds without a frame after which it stands still. */
const STILL = 250;

/** Of the distance to what it looks at: by less the camera is moved by rounding alone. */
const UNMOVED = 1e-6;

/** Pixels of the canvas that lie under what floats on it, above and below; on one so narrow (style/small.css) two rows of it stand below. */
const OVERLAYS = 112, NARROW = 430, OVERLAYS_NARROW = 164;

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(38, 1, 0.01, 100);
  readonly controls: OrbitControls;
  /** Everything whose frame is that of the answer. */
  readonly world = new Group();
  readonly renderer: WebGLRenderer;
  private readonly light = new DirectionalLight(0xffffff, 2.4);
  private readonly ground: Mesh;
  private grid: ReturnType<typeof gridOf> | undefined;
  private asked = 0;
  private waiting: (() => void)[] = [];
  private lastFrame = 0;
  private slowFrames = 0;
  /** Of PACES: what this mesh was found to need on this machine. */
  private pace = 0;
  private rest: ReturnType<typeof setTimeout> | undefined;
  private stillIsDue = false;
  /** Nothing is drawn before: at first there is nothing to see, and the page behind it has the same colour. */
  private from = Infinity;
  /** There is no graphics card: plain materials, and edges as they are. */
  readonly software = drawsInSoftware();
  private beforeFrame: ((seconds: number) => boolean) | undefined;

  /** Told when the graphics card goes and comes back. */
  lost: (gone: boolean) => void = () => {};

  /** Throws where there is no WebGL. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.software, powerPreference: 'high-performance' });
    // Asking for errors waits for each shader by itself, and they are made by three.js.
    this.renderer.debug.checkShaderErrors = false;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.invalidate(false));
    const { shadow } = this.light;
    shadow.mapSize.set(1024, 1024);
    shadow.bias = -0.0006;
    shadow.normalBias = 0.02;
    this.light.castShadow = true;
    this.ground = new Mesh(new PlaneGeometry(1, 1), new ShadowMaterial({ opacity: 0.28 }));
    this.ground.rotation.x = -Math.PI / 2;
    this.ground.receiveShadow = true;
    this.scene.add(new HemisphereLight(0xeef3ff, 0x6b6257, 1.35), this.light, this.light.target, this.ground, this.world);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement ?? canvas);
    canvas.addEventListener('webglcontextlost', event => {
      event.preventDefault();  // else it never comes back
      this.lost(true);
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.lost(false);
      this.invalidate();
    });
    this.resize();
  }

  /** Reflections, which glass and metal need; made when the first picture is there. */
  reflect(): void {
    if (this.scene.environment || this.software) return;
    const generator = new PMREMGenerator(this.renderer);
    this.scene.environment = generator.fromScene(surroundings(), 0.04).texture;
    this.scene.environmentIntensity = 0.45;
    generator.dispose();
    this.invalidate(false);
  }

  colours(background: string, line: string): void {
    this.scene.background = new Color(background);
    this.lineColour = new Color(line);
    if (this.grid) this.makeGrid(this.grid.userData['size'] as number, this.grid.position.y);
    this.invalidate(false);
  }
  private lineColour = new Color(0x888888);

  /** Light, ground and camera for a mesh; the camera only where it is a new one. */
  frame(min: Vector3, max: Vector3, moveCamera: boolean): void {
    const middle = min.clone().add(max).multiplyScalar(0.5), radius = Math.max(1e-6, min.distanceTo(max) / 2);
    this.light.target.position.copy(middle);
    this.light.position.copy(middle).add(new Vector3(1.4, 2.6, 1.9).multiplyScalar(radius));
    const { camera } = this.light.shadow as DirectionalLightShadow;
    camera.left = camera.bottom = -2.6 * radius;
    camera.right = camera.top = 2.6 * radius;
    camera.near = 0.05 * radius;
    camera.far = 9 * radius;
    camera.updateProjectionMatrix();
    this.pace = this.slowFrames = 0;
    this.ground.position.set(middle.x, min.y - 1e-3 * radius, middle.z);
    this.ground.scale.setScalar(60 * radius);
    this.makeGrid(radius, min.y - 1e-3 * radius);
    this.camera.near = radius / 200;
    this.camera.far = radius * 400;
    this.controls.minDistance = radius / 20;
    this.controls.maxDistance = radius * 60;
    if (moveCamera) this.look(middle, radius);
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  /** From where all of such a sphere is seen. */
  private distanceFor(radius: number): number {
    const narrow = Math.min(1, this.camera.aspect), { clientWidth: width, clientHeight: height } = this.canvas;
    const free = Math.max(0.5, 1 - (width <= NARROW ? OVERLAYS_NARROW : OVERLAYS) / Math.max(1, height));
    return Math.max(1.25 / narrow, 1.05 / free) * radius / Math.sin(this.camera.fov * Math.PI / 360);
  }

  private look(middle: Vector3, radius: number): void {
    const distance = this.distanceFor(radius);
    this.room = 1;
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).add(new Vector3().setFromSpherical(new Spherical(distance, 1.28, 0.55)));
    this.controls.update();
    this.placed = { at: this.camera.position.clone(), target: middle.clone(), fit: this.distanceFor(1) };
  }

  /** Where the stage itself put the camera, and what `distanceFor` said of a radius of 1: until somebody moves it, it goes with the window. */
  private placed: { at: Vector3; target: Vector3; fit: number } | undefined;
  private get isAsPlaced(): boolean {
    const { placed, camera: { position }, controls: { target } } = this;
    return placed !== undefined && Math.max(position.distanceTo(placed.at), target.distanceTo(placed.target)) < UNMOVED * placed.at.distanceTo(placed.target);
  }

  private makeGrid(radius: number, y: number): void {
    if (this.grid) {
      this.grid.removeFromParent();
      this.grid.geometry.dispose();
      this.grid.material.dispose();
    }
    this.grid = gridOf(radius, this.lineColour);
    this.grid.position.y = y;
    this.grid.userData['size'] = radius;
    this.scene.add(this.grid);
  }

  /** Calls it before each frame until it says that nothing moves any more; undefined: no more. */
  animate(step: ((seconds: number) => boolean) | undefined): void {
    this.beforeFrame = step;
    this.invalidate();
  }

  /** `shadows`: something moved that throws some. */
  invalidate(shadows = true): void {
    if (shadows) this.renderer.shadowMap.needsUpdate = true;
    this.asked ||= requestAnimationFrame(now => this.draw(now));
  }

  /** When what is there now has been drawn. */
  drawn(): Promise<void> {
    return new Promise(resolve => {
      this.waiting.push(resolve);
      this.invalidate(false);
    });
  }

  /** What is there is not worth a frame yet, which is half a second in software: better comes soon, or it is drawn after all. */
  hold(milliseconds: number): void {
    this.from = performance.now() + milliseconds;
    setTimeout(() => this.invalidate(false), milliseconds);
  }
  /** What was waited for is there. */
  release(): void {
    this.from = 0;
    this.invalidate();
  }

  private draw(now: number): void {
    this.asked = 0;
    if (performance.now() < this.from) return;
    const gap = now - this.lastFrame, still = this.stillIsDue;
    this.lastFrame = now;
    this.stillIsDue = false;
    const goesOn = this.beforeFrame?.(Math.min(0.1, gap / 1000)) ?? false;
    this.render(still ? 0 : this.pace);
    // When the next one could be drawn, whether somebody asks for it or not.
    if (!still) requestAnimationFrame(next => this.measure(next - now));
    for (const resolve of this.waiting.splice(0)) resolve();
    if (goesOn) this.invalidate();
    clearTimeout(this.rest);
    if (this.pace > 0 && !still)
      this.rest = setTimeout(() => {
        if (this.asked !== 0) return;  // it moves, and each frame takes longer than that
        this.stillIsDue = true;
        this.invalidate(false);
      }, STILL);
  }

  private render(pace: number): void {
    this.light.castShadow = pace === 0;
    const dots = Math.min(PACES[pace]!, devicePixelRatio), { clientWidth: width, clientHeight: height } = this.canvas.parentElement ?? this.canvas;
    if (dots !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(dots);
    const { x, y } = this.renderer.getSize(new Vector2());
    // Only here: a canvas that gets a size is empty until it is drawn.
    if (width * height > 0 && (x !== width || y !== height)) this.renderer.setSize(width, height, false);
    this.renderer.render(this.scene, this.camera);
  }

  /** One after the other is late: this machine draws in software, or nearly so. */
  private measure(gap: number): void {
    if (gap > 1000 || this.pace + 1 >= PACES.length) return;
    this.slowFrames = gap > SLOW ? this.slowFrames + 1 : Math.max(0, this.slowFrames - 1);
    if (this.slowFrames < PATIENCE) return;
    ++this.pace;
    this.slowFrames = 0;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement ?? this.canvas;
    if (width === 0 || height === 0) return;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.placed) {
      const fit = this.distanceFor(1);
      if (this.isAsPlaced) this.retreat(fit / this.placed.fit);
      this.placed.fit = fit;
    }
    this.invalidate(false);
  }

  /** From the camera through a place of the canvas, in pixels of the page. */
  ray(x: number, y: number): Ray {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new Vector2((x - left) / width * 2 - 1, 1 - (y - top) / height * 2), ray = new Ray();
    this.camera.updateMatrixWorld();
    ray.origin.setFromMatrixPosition(this.camera.matrixWorld);
    ray.direction.set(at.x, at.y, 0.5).unproject(this.camera).sub(ray.origin).normalize();
    return ray;
  }

  /** In pixels of the page; undefined behind the camera. */
  pixelOf(at: Vector3): [number, number] | undefined {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    const { x, y, z } = at.clone().project(this.camera);
    return z > 1 ? undefined : [left + (x + 1) / 2 * width, top + (1 - y) / 2 * height];
  }

  /** How much farther away than somebody placed it the camera is, for what is spread. */
  private room = 1;
  /** What is spread to `spread` times the radius that is usual stays in the picture; gathered again, the camera comes back. Who is
   * nearer than all of it goes away by as much. */
  makeRoom(usual: number, spread: number): void {
    const now = this.camera.position.distanceTo(this.controls.target), own = now / this.room;
    const next = Math.max(1, this.distanceFor(usual * spread) / Math.max(own, this.distanceFor(usual)));
    if (Math.abs(next - this.room) < 1e-6) return;
    this.retreat(next / this.room);
    this.room = next;
    this.invalidate(false);
  }

  /** Farther away, so that what falls apart is in the picture. */
  retreat(factor: number): void {
    const { isAsPlaced } = this;
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    if (isAsPlaced) this.placed!.at.copy(this.camera.position);
  }

  add(object: Object3D): void {
    this.world.add(object);
    this.invalidate();
  }

  /** The view as PNG. */
  async picture(): Promise<Blob> {
    this.render(0);
    return new Promise((resolve, reject) => this.canvas.toBlob(blob => (blob ? resolve(blob) : reject(new Error('no picture'))), 'image/png'));
  }

  get groundHeight(): number {
    return this.ground.position.y;
  }
}

function drawsInSoftware(): boolean {
  const context = document.createElement('canvas').getContext('webgl2'), names = context?.getExtension('WEBGL_debug_renderer_info');
  const name = String(context?.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER) ?? '');
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
