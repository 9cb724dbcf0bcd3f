// Pointer, touch and keys on the canvas. A press that moves rotates the view (OrbitControls); a press that does not move uses the tool.
import type { Vector3 } from 'fracture-client';
import type { App } from './app';

/** Distances in pixels. A press that moves less than STILL is a click; a handle within HOLD can be grabbed. Fingers are less precise
 * than a mouse. */
const STILL = 5, STILL_FINGER = 12, HOLD = 13, HOLD_FINGER = 26;

export function listen(app: App, canvas: HTMLCanvasElement): void {
  let down: { x: number; y: number; pointer: number } | undefined, several = false, hover: { x: number; y: number } | undefined;
  // The thing being dragged, and by which pointer: a handle, or (without a modifier key) a piece while playing.
  let held: { pointer: number; key?: string } | undefined;
  const pointers = new Set<number>();
  canvas.addEventListener('pointerdown', event => {
    pointers.add(event.pointerId);
    several = pointers.size > 1;
    down = event.button === 0 ? { x: event.clientX, y: event.clientY, pointer: event.pointerId } : undefined;
    app.view?.reachAt(undefined, 1);
    const key = event.button === 0 && !several ? handleAt(app, event) : undefined;
    if (key !== undefined) {
      held = { key, pointer: event.pointerId };
      canvas.setPointerCapture(event.pointerId);
    } else if (!held && app.state.play && event.button === 0 && app.physics?.grab(event.clientX, event.clientY)) held = { pointer: event.pointerId };
    if (held) app.stage!.controls.enabled = false;
  }, { capture: true });
  addEventListener('pointerup', event => {
    pointers.delete(event.pointerId);
    let dragged = false;
    if (held?.pointer === event.pointerId) {
      if (held.key === undefined) dragged = app.physics?.release() ?? false;
      else {
        dragHandle(app, held.key, event, true);
        down = undefined;
      }
      held = undefined;
    }
    if (app.stage && !held) app.stage.controls.enabled = true;
    if (!down || down.pointer !== event.pointerId || several || event.target !== canvas) return;
    const moved = Math.hypot(event.clientX - down.x, event.clientY - down.y);
    down = undefined;
    if (moved <= (event.pointerType === 'touch' ? STILL_FINGER : STILL) && !dragged) use(app, event.clientX, event.clientY, event.shiftKey || event.ctrlKey);
  });
  const cancelled = (event: PointerEvent) => {
    pointers.delete(event.pointerId);
    if (held && held.pointer !== event.pointerId) return;  // belongs to another finger
    if (held?.key !== undefined) app.breaking.letGo();
    else app.physics?.release();
    held = down = undefined;
    if (app.stage) app.stage.controls.enabled = true;
    if (canvas.hasPointerCapture(event.pointerId)) canvas.releasePointerCapture(event.pointerId);
  };
  addEventListener('pointercancel', cancelled);
  canvas.addEventListener('pointermove', event => {
    if (held?.pointer === event.pointerId) {
      if (event.buttons === 0) cancelled(event);  // the button was released unnoticed, for example behind a locked screen
      else if (held.key !== undefined) dragHandle(app, held.key, event, false);
      else app.physics?.drag(event.clientX, event.clientY);
      return;
    }
    if (event.pointerType === 'touch' || event.buttons !== 0 || app.state.play) return;
    const first = hover === undefined;
    hover = { x: event.clientX, y: event.clientY };
    if (first) requestAnimationFrame(() => {
      if (hover) preview(app, canvas, hover.x, hover.y);
      hover = undefined;
    });
  });
  canvas.addEventListener('pointerleave', () => {
    hover = undefined;
    app.view?.reachAt(undefined, 1);
  });
  canvas.addEventListener('keydown', event => steer(app, event));
}

function handleAt(app: App, { clientX, clientY, pointerType }: PointerEvent): string | undefined {
  return app.state.play ? undefined : app.view?.handleAt(clientX, clientY, pointerType === 'touch' ? HOLD_FINGER : HOLD);
}
function dragHandle(app: App, key: string, { clientX, clientY }: PointerEvent, settled: boolean): void {
  const settings = app.view?.dragged(key, clientX, clientY);
  if (settings) app.breaking.drag(key, settings, settled);
}

/** Shows the sphere that a hit at the pointer would reach, or no sphere over a handle. */
function preview(app: App, canvas: HTMLCanvasElement, x: number, y: number): void {
  const { tool, radius, shown } = app.state, handle = app.view?.handleAt(x, y, HOLD) !== undefined;
  canvas.classList.toggle('on-handle', handle);
  const picked = shown && tool !== 'select' && !handle ? app.view?.pick(x, y) : undefined;
  app.view?.reachAt(picked?.world.toArray(), radius);
}

export function use(app: App, x: number, y: number, more = false): void {
  const { tool, play, shown } = app.state;
  if (play) {
    app.physics?.throwAt(x, y);
    return;
  }
  const picked = app.view?.pick(x, y);
  if (!picked) {
    if (tool === 'select') app.choose([]);
    return;
  }
  if (!shown) return;
  if (app.breaking.pickingFor) {
    app.breaking.givePoint(picked.point as Vector3);
    return;
  }
  if (tool === 'select') {
    if (picked.id !== undefined) app.chooseInView(picked.id, more);
  } else if (tool === 'aim') app.breaking.aimAt(picked.point as Vector3);
  else app.breaking.hitAt(picked.point as Vector3);
}

function steer(app: App, event: KeyboardEvent): void {
  const { stage } = app;
  if (!stage || event.ctrlKey || event.metaKey || event.altKey) return;
  const { controls, camera } = stage, angle = 0.1;
  const by: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  const arrow = by[event.key];
  if (arrow) {
    const offset = camera.position.clone().sub(controls.target), [h, v] = arrow;
    if (event.shiftKey) {
      const step = offset.length() * 0.05, side = camera.up.clone().cross(offset).normalize().multiplyScalar(h * step);
      const shift = side.addScaledVector(camera.up, v * step);
      camera.position.add(shift);
      controls.target.add(shift);
    } else {
      offset.applyAxisAngle(camera.up, -h * angle);
      const side = camera.up.clone().cross(offset).normalize(), tilted = offset.clone().applyAxisAngle(side, -v * angle);
      if (Math.abs(tilted.clone().normalize().dot(camera.up)) < 0.99) offset.copy(tilted);
      camera.position.copy(controls.target).add(offset);
    }
  } else if (event.key === '+' || event.key === '=' || event.key === '-') {
    camera.position.lerp(controls.target, event.key === '-' ? -0.15 : 0.13);
  } else if (event.key === 'Enter') {
    const at = app.state.play ? middle(stage.renderer.domElement, 0, 0) : nearestMiddle(app, stage.renderer.domElement);
    if (at) use(app, ...at, event.shiftKey);
  } else return;
  event.preventDefault();
  controls.update();
  stage.invalidate(false);
}

function middle(canvas: HTMLCanvasElement, ring: number, angle: number): [number, number] {
  const { left, top, width, height } = canvas.getBoundingClientRect(), r = ring * Math.min(width, height);
  return [left + width / 2 + r * Math.cos(angle), top + height / 2 + r * Math.sin(angle)];
}

/** Returns the point on the canvas, near its centre, where the mesh is. The centre itself may be a gap between fragments. */
function nearestMiddle(app: App, canvas: HTMLCanvasElement): [number, number] | undefined {
  for (let ring = 0; ring < 0.4; ring += 0.04)
    for (let k = 0; k < 8; ++k) {
      const at = middle(canvas, ring, k * Math.PI / 4);
      if (app.view?.pick(...at)) return at;
    }
  return undefined;
}
