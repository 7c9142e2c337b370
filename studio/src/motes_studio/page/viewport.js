// How the film lies on the stage: screen = scale * (film + 1/2) + offset. Immutable.

export class Viewport {
  constructor(scale, x, y) {
    Object.assign(this, { scale, x, y });
    Object.freeze(this);
  }

  /** Return the viewport that shows the whole film in the middle of a stage. */
  static fit(film, stage, margin = 12) {
    const free = [stage.width - 2 * margin, stage.height - 2 * margin];
    const scale = Math.max(0.01, Math.min(free[0] / film.width, free[1] / film.height));
    return new Viewport(
      scale,
      (stage.width - scale * film.width) / 2,
      (stage.height - scale * film.height) / 2,
    );
  }

  toScreen([x, y]) {
    return [this.scale * (x + 0.5) + this.x, this.scale * (y + 0.5) + this.y];
  }

  toFilm([x, y]) {
    return [(x - this.x) / this.scale - 0.5, (y - this.y) / this.scale - 0.5];
  }

  /** Return this viewport zoomed about a point of the screen. */
  zoomed(factor, [x, y]) {
    const scale = Math.min(64, Math.max(0.02, this.scale * factor));
    const ratio = scale / this.scale;
    return new Viewport(scale, x - (x - this.x) * ratio, y - (y - this.y) * ratio);
  }

  panned(dx, dy) {
    return new Viewport(this.scale, this.x + dx, this.y + dy);
  }
}
