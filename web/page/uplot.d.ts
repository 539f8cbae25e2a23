// As much of uPlot (web/vendor/uplot) as the page uses.

declare class uPlot {
  constructor(options: object, data: (number | null)[][], target: HTMLElement);
  readonly ctx: CanvasRenderingContext2D;
  readonly bbox: { left: number; top: number; width: number; height: number };
  destroy(): void;
  setData(data: (number | null)[][], resetScales?: boolean): void;
  setScale(key: string, limits: { min: number; max: number }): void;
  setSize(size: { width: number; height: number }): void;
  valToPos(value: number, scale: string, canvasPixels?: boolean): number;
}
