// The viewport: renderer, camera, light and ground. It draws only when something has changed.
import {
  Color, DirectionalLight, type DirectionalLightShadow, Group, HemisphereLight, Mesh, Object3D, PCFShadowMap, PerspectiveCamera,
  PlaneGeometry, PMREMGenerator, Ray, Scene, ShadowMaterial, Spherical, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { gridOf } from './grid';
import { surroundings } from './surroundings';

/** The frame time (ms) above which a frame is slow, and the number of slow frames in a row that lead to a cheaper way of drawing. */
const SLOW = 90, PATIENCE = 6;
/** Resolutions (dots per page pixel, at most) for pictures in motion. Slow frames move on to the next one. Only the first draws shadows,
 * because shadows take half of the time of a frame that is drawn in software. The last is blurred, but motion still follows the mouse.
 * Pictures without motion have full quality. */
const PACES = [2, 0.8, 0.6, 0.45] as const;
/** Time in ms without a frame, after which the picture is considered still. */
const STILL = 250;

/** A fraction of the distance to the target. Smaller camera movements are only rounding errors. */
const UNMOVED = 1e-6;

/** Height in pixels of the controls that cover the canvas, above and below together. It is larger on a narrow canvas (style/small.css),
 * because there are two rows below. */
const OVERLAYS = 112, NARROW = 430, OVERLAYS_NARROW = 164;

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(38, 1, 0.01, 100);
  readonly controls: OrbitControls;
  /** Everything in the frame of the answer. */
  readonly world = new Group();
  readonly renderer: WebGLRenderer;
  private readonly light = new DirectionalLight(0xffffff, 2.4);
  private readonly ground: Mesh;
  private grid: ReturnType<typeof gridOf> | undefined;
  private asked = 0;
  private waiting: (() => void)[] = [];
  private lastFrame = 0;
  private slowFrames = 0;
  /** An index into PACES: the pace found for this mesh on this machine. */
  private pace = 0;
  private rest: ReturnType<typeof setTimeout> | undefined;
  private stillIsDue = false;
  /** The time before which nothing is drawn. At first there is nothing to see, and the page behind the canvas has the same colour. */
  private from = Infinity;
  /** True if the browser draws without a graphics card. Then materials are plain and edges are not smoothed. */
  readonly software = drawsInSoftware();
  private beforeFrame: ((seconds: number) => boolean) | undefined;

  /** Called when the graphics card is lost or comes back. */
  lost: (gone: boolean) => void = () => {};

  /** Throws if there is no WebGL. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.software, powerPreference: 'high-performance' });
    // A check for errors would wait for each shader separately, and shaders from three.js have none.
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
      event.preventDefault();  // otherwise it never comes back
      this.lost(true);
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.lost(false);
      this.invalidate();
    });
    this.resize();
  }

  /** Adds reflections, which glass and metal need. It is called after the first picture. */
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

  /** Sets light and ground for a mesh, and the camera if the mesh is new. */
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

  /** Returns the distance from which a sphere of this size is completely visible. */
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

  /** Moves the camera so that this sphere fills the view, in the direction in which it looks. Light and ground stay. */
  aim(middle: Vector3, radius: number): void {
    const distance = this.distanceFor(Math.max(1e-9, radius));
    const along = this.camera.position.clone().sub(this.controls.target).normalize();
    this.room = 1;
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(along, Math.max(distance, this.controls.minDistance));
    this.controls.update();
    this.invalidate(false);
  }

  /** The camera position that the stage chose, and `distanceFor(1)`. Until a user moves the camera, it follows the window size. */
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

  /** Calls `step` before each frame until it returns false, which means that nothing moves any more. undefined stops this. */
  animate(step: ((seconds: number) => boolean) | undefined): void {
    this.beforeFrame = step;
    this.invalidate();
  }

  /** Requests a frame. `shadows`: something that casts shadows has moved. */
  invalidate(shadows = true): void {
    if (shadows) this.renderer.shadowMap.needsUpdate = true;
    this.asked ||= requestAnimationFrame(now => this.draw(now));
  }

  /** Resolves when the current contents have been drawn. */
  drawn(): Promise<void> {
    return new Promise(resolve => {
      this.waiting.push(resolve);
      this.invalidate(false);
    });
  }

  /** Draws nothing for this long, because better contents will follow soon and a software frame takes half a second. */
  hold(milliseconds: number): void {
    this.from = performance.now() + milliseconds;
    setTimeout(() => this.invalidate(false), milliseconds);
  }
  /** Draws again, because the awaited contents have arrived. */
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
    // Measures when the next frame could be drawn, even if none was requested.
    if (!still) requestAnimationFrame(next => this.measure(next - now));
    for (const resolve of this.waiting.splice(0)) resolve();
    if (goesOn) this.invalidate();
    clearTimeout(this.rest);
    if (this.pace > 0 && !still)
      this.rest = setTimeout(() => {
        if (this.asked !== 0) return;  // something is moving, and each frame takes longer than STILL
        this.stillIsDue = true;
        this.invalidate(false);
      }, STILL);
  }

  private render(pace: number): void {
    this.light.castShadow = pace === 0;
    const dots = Math.min(PACES[pace]!, devicePixelRatio), { clientWidth: width, clientHeight: height } = this.canvas.parentElement ?? this.canvas;
    if (dots !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(dots);
    const { x, y } = this.renderer.getSize(new Vector2());
    // The canvas is resized only here, because resizing clears it until it is drawn again.
    if (width * height > 0 && (x !== width || y !== height)) this.renderer.setSize(width, height, false);
    this.renderer.render(this.scene, this.camera);
  }

  /** Chooses a cheaper pace if frames are repeatedly late, which means that this machine draws in software or nearly so. */
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

  /** Returns the ray from the camera through a point on the canvas, in page pixels. */
  ray(x: number, y: number): Ray {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new Vector2((x - left) / width * 2 - 1, 1 - (y - top) / height * 2), ray = new Ray();
    this.camera.updateMatrixWorld();
    ray.origin.setFromMatrixPosition(this.camera.matrixWorld);
    ray.direction.set(at.x, at.y, 0.5).unproject(this.camera).sub(ray.origin).normalize();
    return ray;
  }

  /** Converts a point to page pixels; undefined if it is behind the camera. */
  pixelOf(at: Vector3): [number, number] | undefined {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    const { x, y, z } = at.clone().project(this.camera);
    return z > 1 ? undefined : [left + (x + 1) / 2 * width, top + (1 - y) / 2 * height];
  }

  /** The factor by which exploded fragments have moved the camera away from where the user placed it. */
  private room = 1;
  /** Keeps fragments in view that are exploded to `spread` times the usual radius. When they are assembled again, the camera
   * returns. A user who is closer is moved back by the same factor. */
  makeRoom(usual: number, spread: number): void {
    const now = this.camera.position.distanceTo(this.controls.target), own = now / this.room;
    const next = Math.max(1, this.distanceFor(usual * spread) / Math.max(own, this.distanceFor(usual)));
    if (Math.abs(next - this.room) < 1e-6) return;
    this.retreat(next / this.room);
    this.room = next;
    this.invalidate(false);
  }

  /** Multiplies the camera's distance by a factor, so that falling pieces stay in the picture. */
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

  /** Returns the view as PNG. */
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
