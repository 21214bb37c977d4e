// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the charts of a report: in every element of class chart, the JSON of the script that its data-chart names.
(() => {
  "use strict";

  const kPrintWidth = 660;  // CSS px that fit a printed page
  const kNumColors = 6;
  const kMarkRowHeight = 16;
  const kMostDottedSamples = 40;  // a line of so few samples shows them as dots
  const kAxisFont = "12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
  const kLabelFont = "13px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // Five significant digits, with an exponent only where zeros would take over.
  function value_text(value) {
    if (value == null) return "–";
    const size = Math.abs(value);
    const rounded = +value.toPrecision(5);
    return size !== 0 && (size >= 1e6 || size < 1e-4) ? rounded.toExponential() : String(rounded);
  }

  // As many decimals as the step between ticks needs, the same for all of them.
  function linear_tick_texts(ticks, step) {
    const largest = Math.max(...ticks.map(Math.abs));
    if (largest >= 1e6 || step < 1e-5) {
      const digits = Math.max(0, Math.floor(Math.log10(largest / step) + 1e-9));
      return ticks.map((tick) => (tick === 0 ? "0" : tick.toExponential(digits)));
    }
    const is_whole = (number) => Math.abs(Math.round(number) - number) <= 1e-6 * number;
    let decimals = 0;
    while (decimals < 6 && !is_whole(step * 10 ** decimals)) ++decimals;
    return ticks.map((tick) => tick.toFixed(decimals));
  }

  function power_text(power) {
    return "10" + String(power).replace(/[-0-9]/g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]));
  }

  // The powers of ten among the ticks if there are two or more of them, else all ticks; null: not one of those.
  function main_log_ticks(ticks) {
    const is_power = (tick) => tick != null && Math.abs(Math.log10(tick) - Math.round(Math.log10(tick))) < 1e-9;
    return ticks.filter(is_power).length < 2 ? ticks : ticks.map((tick) => (is_power(tick) ? tick : null));
  }

  function log_tick_texts(ticks) {
    const powers = ticks.filter((tick) => tick != null).every((tick) => Number.isInteger(+Math.log10(tick).toFixed(9)));
    const text = (tick) => (powers ? power_text(Math.round(Math.log10(tick))) : String(+tick.toPrecision(3)));
    return ticks.map((tick) => (tick == null ? "" : text(tick)));
  }

  // A sample with gaps on both sides would be a line of no length: it gets a dot.
  function lonely_samples(plot, series_index, shown) {
    if (shown) return null;
    const y = plot.data[series_index];
    const lonely = [];
    let before = null;  // index of the sample before, null: a gap or nothing
    let candidate = null;
    for (let i = 0; i < y.length; ++i) {
      if (y[i] === undefined) continue;
      if (y[i] === null) {
        if (candidate !== null) lonely.push(candidate);
        before = candidate = null;
      } else {
        candidate = before === null ? i : null;
        before = i;
      }
    }
    if (candidate !== null) lonely.push(candidate);
    return lonely.length ? lonely : null;
  }

  function series_options(series, index) {
    const stroke = color(`--series-${(index % kNumColors) + 1}`);
    const points = series.style === "points";
    const few = series.style === "line" && series.y.filter((y) => typeof y === "number").length <= kMostDottedSamples;
    return {
      label: series.label,
      class: series.style,
      stroke,
      width: points ? 0 : 1.6,
      pxAlign: 0,  // samples stay where they are, between pixels too
      dash: series.style === "dashed" ? [6, 4] : undefined,
      paths: points ? () => null : undefined,
      points: { show: points || few, size: few || series.bars.length ? 6 : 4, width: 0, fill: stroke, stroke, filter: lonely_samples },
      value: (plot, value) => value_text(value),
    };
  }

  // The labels of the marks stand above the plot, on as many rows as keep them apart. `place_of` gives the canvas pixel of an x.
  function arrange_marks(marks, ctx, place_of, left, right) {
    const ratio = devicePixelRatio;
    ctx.save();
    ctx.font = kAxisFont.replace("12px", `${12 * ratio}px`);
    const arranged = marks
      .filter((mark) => mark.x !== null)
      .map((mark) => ({ label: mark.label, place: place_of(mark.x), width: ctx.measureText(mark.label).width }))
      .filter((mark) => mark.place >= left - 1 && mark.place <= right + 1)
      .sort((a, b) => b.place - a.place);
    ctx.restore();
    // A label keeps clear of the labels on its row and of the lines that rise through it to higher rows.
    const gap = 8 * ratio;
    arranged.forEach((mark, index) => {
      mark.start = Math.min(mark.place, right - mark.width);
      const end = mark.start + mark.width + gap;
      const collides = (other) => (other.row === mark.row && end > other.start)
        || (other.row > mark.row && other.place > mark.start && other.place < end);
      mark.row = 0;
      while (arranged.slice(0, index).some(collides)) ++mark.row;
    });
    const num_rows = Math.max(0, ...arranged.map((mark) => mark.row + 1));
    return { arranged, num_rows };
  }

  // Room above the plot for the labels; the place of the plot is not settled yet, its margins are near enough.
  function room_for_marks(marks) {
    return (plot) => {
      const { min, max } = plot.scales.x;
      if (!marks.length || min == null || !(max > min)) return 8;
      const left = 64 * devicePixelRatio;
      const right = (plot.width - 16) * devicePixelRatio;
      const place_of = (x) => left + ((x - min) / (max - min)) * (right - left);
      return 10 + kMarkRowHeight * arrange_marks(marks, plot.ctx, place_of, left, right).num_rows;
    };
  }

  function draw_marks(marks) {
    return (plot) => {
      const { ctx, bbox } = plot;
      const ratio = devicePixelRatio;
      const { arranged } = arrange_marks(marks, ctx, (x) => plot.valToPos(x, "x", true), bbox.left, bbox.left + bbox.width);
      ctx.save();
      ctx.font = kAxisFont.replace("12px", `${12 * ratio}px`);
      ctx.textBaseline = "bottom";
      ctx.textAlign = "left";
      ctx.lineWidth = ratio;
      ctx.strokeStyle = ctx.fillStyle = color("--muted");
      ctx.setLineDash([2 * ratio, 3 * ratio]);
      for (const mark of arranged) {
        const bottom = bbox.top - (4 + kMarkRowHeight * mark.row) * ratio;
        ctx.beginPath();
        ctx.moveTo(mark.place, mark.row === 0 ? bbox.top : bottom + ratio);
        ctx.lineTo(mark.place, bbox.top + bbox.height);
        ctx.stroke();
        ctx.fillText(mark.label, mark.start, bottom);
      }
      ctx.restore();
    };
  }

  const all_bars = (content) => content.series.flatMap((series) => series.bars);

  // From what uPlot found in the samples to what the error bars of the shown places need.
  function range_with_bars(content) {
    return (plot, low, high) => {
      if (low == null || high == null) return [null, null];
      const { min, max } = plot.scales.x;
      const bars = all_bars(content).filter(([x]) => (min == null || x >= min) && (max == null || x <= max));
      const lowest = Math.min(low, ...bars.map((bar) => bar[1]));
      const highest = Math.max(high, ...bars.map((bar) => bar[2]));
      return content.log_y ? uPlot.rangeLog(lowest, highest, 10, false) : uPlot.rangeNum(lowest, highest, 0.1, false);
    };
  }

  // Half a tenth of room at the sides, so that no point stands on the frame.
  function padded_log_range(plot, low, high) {
    if (low == null || high == null) return [null, null];
    const room = Math.max((high / low) ** 0.05, 1.02);
    return [low / room, high * room];
  }

  function draw_bars(content) {
    return (plot, index) => {
      const series = content.series[index - 1];
      if (!series || !series.bars.length || !plot.series[index].show) return;
      const { ctx, bbox } = plot;
      const cap = 3.5 * devicePixelRatio;
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
      ctx.strokeStyle = color(`--series-${((index - 1) % kNumColors) + 1}`);
      ctx.lineWidth = 1.4 * devicePixelRatio;
      for (const [x, low, high] of series.bars) {
        const place = plot.valToPos(x, "x", true);
        const ends = [low, high].map((y) => plot.valToPos(y, "y", true));
        ctx.beginPath();
        ctx.moveTo(place, ends[0]);
        ctx.lineTo(place, ends[1]);
        for (const end of ends) {
          ctx.moveTo(place - cap, end);
          ctx.lineTo(place + cap, end);
        }
        ctx.stroke();
      }
      ctx.restore();
    };
  }

  function axis_options(label, log) {
    const filter = log ? { filter: (plot, ticks) => main_log_ticks(ticks) } : {};
    return {
      label,
      labelFont: kLabelFont,
      font: kAxisFont,
      stroke: color("--muted"),
      ...filter,
      grid: { stroke: color("--grid"), width: 1, ...filter },
      ticks: { show: false },
      values: log ? (plot, ticks) => log_tick_texts(ticks) : (plot, ticks, axis, space, step) => linear_tick_texts(ticks, step),
    };
  }

  function y_axis_size(plot, texts) {
    const longest = Math.max(0, ...(texts ?? []).map((text) => text.length));
    return Math.max(34, 14 + 7 * longest);
  }

  const height_for = (width) => Math.round(Math.min(360, Math.max(230, 0.46 * width)));

  function draw(chart) {
    const { host, content } = chart;
    const width = chart.width ?? host.clientWidth;
    host.replaceChildren();
    const options = {
      width,
      height: height_for(width),
      padding: [room_for_marks(content.marks), null, null, null],
      scales: {
        x: content.log_x ? { time: false, distr: 3, range: padded_log_range } : { time: false },
        y: {
          ...(content.log_y ? { distr: 3 } : {}),
          ...(all_bars(content).length ? { range: range_with_bars(content) } : {}),
        },
      },
      axes: [
        { ...axis_options(content.x_label, content.log_x), size: 30, labelSize: 22 },
        { ...axis_options(content.y_label, content.log_y), size: y_axis_size, labelSize: 22 },
      ],
      series: [
        { label: content.x_label, value: (plot, value) => value_text(value) },
        ...content.series.map(series_options),
      ],
      cursor: { drag: { x: true, y: false, setScale: true }, points: { size: 7 } },
      legend: {
        markers: {
          width: 2,
          stroke: (plot, index) => color(`--series-${((index - 1) % kNumColors) + 1}`),
          fill: (plot, index) => (content.series[index - 1].style === "points"
            ? color(`--series-${((index - 1) % kNumColors) + 1}`) : "transparent"),
          dash: (plot, index) => (content.series[index - 1].style === "dashed" ? "dashed" : "solid"),
        },
      },
      hooks: { draw: [draw_marks(content.marks)], drawSeries: [draw_bars(content)] },
    };
    chart.plot = new uPlot(options, chart.data, host);
  }

  const charts = [...document.querySelectorAll(".chart")].map((host) => {
    const content = JSON.parse(document.getElementById(host.dataset.chart).textContent);
    const column = (series) => series.y.map((y) => (y === "" ? undefined : y));
    return { host, content, data: [content.x, ...content.series.map(column)] };
  });
  const draw_all = () => charts.forEach(draw);
  draw_all();

  const hint = document.createElement("figcaption");
  hint.className = "hint";
  hint.textContent = "Drag across a chart to look closer, double-click to see all of it, click a name to hide its curve.";
  charts[0]?.host.after(hint);

  const watcher = new ResizeObserver(() => {
    for (const { host, plot, width } of charts) {
      if (width === undefined && Math.abs(plot.width - host.clientWidth) >= 1) {
        plot.setSize({ width: host.clientWidth, height: height_for(host.clientWidth) });
      }
    }
  });
  charts.forEach(({ host }) => watcher.observe(host));

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw_all);

  const set_printing = (printing) => {
    document.documentElement.toggleAttribute("data-print", printing);
    charts.forEach((chart) => (chart.width = printing ? kPrintWidth : undefined));
    draw_all();
  };
  addEventListener("beforeprint", () => set_printing(true));
  addEventListener("afterprint", () => set_printing(false));
})();
