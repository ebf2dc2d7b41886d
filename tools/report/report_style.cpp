#include "tools/report/report_style.hpp"

namespace truepose::report {

const std::string_view kStyleSheet = R"css(
:root { --ink: #18232e; --muted: #586673; --line: #dfe5ea; --soft: #f4f7f9;
  --before: #d55e00; --compensated: #00805e; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0; background: var(--soft); color: var(--ink); line-height: 1.5; font-size: 15px;
  font-family: Inter, "Segoe UI", "Helvetica Neue", Roboto, "Noto Sans", "Liberation Sans", Arial, sans-serif;
  -webkit-print-color-adjust: exact; print-color-adjust: exact; }
main { max-width: 1120px; margin: 0 auto; padding: 28px 20px 48px; }
header { margin: 0 4px 20px; }
.eyebrow { margin: 0; color: var(--muted); font-size: 12px; font-weight: 600; letter-spacing: .09em; text-transform: uppercase; }
h1 { margin: 2px 0 0; font-size: 28px; line-height: 1.25; font-weight: 650; letter-spacing: -.01em; overflow-wrap: anywhere; }
.identity { max-width: none; margin: 4px 0 0; color: var(--muted); overflow-wrap: anywhere; }
section { background: #fff; border: 1px solid var(--line); border-radius: 10px; padding: 22px 26px 24px; margin: 0 0 18px; }
h2 { margin: 0 0 4px; font-size: 18px; font-weight: 650; }
h3 { margin: 22px 0 8px; font-size: 14px; font-weight: 650; }
p { margin: 0 0 12px; max-width: 78ch; }
.note { color: var(--muted); font-size: 13.5px; }
.headline { display: flex; flex-wrap: wrap; align-items: baseline; gap: 2px 16px; margin: 4px 0 6px;
  font-size: 42px; line-height: 1.15; font-weight: 680; letter-spacing: -.02em; font-variant-numeric: tabular-nums; }
.headline small { font-size: .5em; font-weight: 500; letter-spacing: 0; }
.headline .was { color: var(--before); }
.headline .now { color: var(--compensated); }
.headline .arrow { color: #a3afba; font-weight: 400; }
.headline .factor { font-size: 20px; font-weight: 600; letter-spacing: 0; }
.verdict { max-width: none; margin: 10px 0 14px; padding: 10px 14px; border-left: 4px solid; border-radius: 4px; font-weight: 550; }
.verdict.use { border-color: var(--compensated); background: #e4f3ee; color: #00432f; }
.verdict.caution { border-color: #b97700; background: #fdf1dc; color: #5c3a00; }
.verdict.refuse { border-color: #b3261e; background: #fbe4e2; color: #7a140e; }
.bars { display: grid; grid-template-columns: max-content 1fr max-content; gap: 7px 14px; align-items: center; margin: 16px 0; font-size: 14px; }
.bar { height: 12px; background: var(--soft); border-radius: 3px; }
.bar i { display: block; height: 100%; min-width: 2px; border-radius: 3px; }
.bars b { font-weight: 600; text-align: right; font-variant-numeric: tabular-nums; }
.badges { display: flex; flex-wrap: wrap; gap: 8px; margin: 0; padding: 0; list-style: none; font-size: 13px; font-weight: 550; }
.badges li { padding: 3px 11px; border-radius: 99px; background: #e4f3ee; color: #00563f; }
.badges li.warning { background: #fdebdd; color: #8a3c00; }
.scroll { overflow-x: auto; margin: 8px 0 0; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th, td { padding: 6px 9px; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
thead th { color: var(--muted); font-size: 12.5px; font-weight: 600; vertical-align: bottom; }
thead th.group { text-align: center; border-bottom: 0; padding-bottom: 0; }
tbody th { font-weight: 500; text-align: left; padding-left: 0; }
tbody th.rows { padding-top: 16px; font-weight: 650; }
td.first, th.first { padding-left: 20px; }
td.strong { font-weight: 650; }
td .spread { display: block; color: var(--muted); font-size: .9em; font-weight: 400; }
td.text { text-align: left; }
tr.convention td, tr.convention th { color: var(--muted); }
.key { display: inline-block; width: 9px; height: 9px; margin-right: 8px; border-radius: 2px; }
.key-line { font-size: 13px; }
.key-line .key:not(:first-child) { margin-left: 14px; }
.columns { display: grid; grid-template-columns: 1fr 1fr; gap: 0 40px; }
.facts { break-inside: avoid; }
.facts h3 { margin: 14px 0 2px; }
.facts th { width: 42%; color: var(--muted); white-space: normal; }
.facts td { text-align: left; white-space: normal; overflow-wrap: anywhere; padding-right: 0; }
.charts { display: grid; grid-template-columns: 1fr 1fr; gap: 18px 30px; margin: 8px 0 4px; }
.charts.three { grid-template-columns: 1fr 1fr 1fr; }
.chart { display: block; width: 100%; height: auto; font-family: inherit; }
section > .chart { max-width: 860px; }
.cloud-view text { paint-order: stroke; stroke: #fff; stroke-width: 3px; }
.chart-title { font-size: 13px; font-weight: 650; fill: #18232e; }
.legend, .tick { font-size: 12px; fill: #586673; }
.grid { stroke: #e6ebef; fill: none; }
.zero, .axis { stroke: #8e9aa5; fill: none; }
.layers .gain { width: 30%; min-width: 90px; }
.layers .bar { display: block; }
.layers .bar i { min-width: 0; }
.figures, .rejected { max-width: 860px; }
.figures .meaning { color: var(--muted); white-space: normal; }
.sentences, .files { margin: 0 0 12px; padding-left: 20px; }
.scroll + .note { margin-top: 10px; }
section + .part { margin-top: 40px; }
p.caution { padding: 10px 14px; border-left: 4px solid var(--before); background: #fdebdd; color: #6e3000; }
.cloud input { position: absolute; opacity: 0; }
.cloud label { display: inline-block; margin: 0 0 14px; padding: 5px 14px; border: 1px solid var(--line); font-size: 13px; cursor: pointer; }
.cloud label:first-of-type { border-radius: 6px 0 0 6px; }
.cloud label:last-of-type { border-radius: 0 6px 6px 0; }
.cloud label + input + label { border-left: 0; }
.cloud input:checked + label { background: var(--ink); border-color: var(--ink); color: #fff; }
.cloud input:focus-visible + label { outline: 2px solid #0072b2; outline-offset: 2px; }
.views { display: none; }
.views h3 { margin: 0 0 6px; }
#cloud0:checked ~ .view0, #cloud1:checked ~ .view1, #cloud2:checked ~ .view2 { display: block; }
.cloud-view { border: 1px solid var(--line); border-radius: 6px; padding: 8px; }
.turns { cursor: grab; touch-action: pan-y; user-select: none; -webkit-user-select: none; }
.beam { stroke: #8e9aa5; stroke-dasharray: 5 4; }
.base { fill: #18232e; }
.base-axis { stroke: #18232e; stroke-width: 1.6; }
.tracker { fill: #586673; }
.mark { fill: #fff; fill-opacity: .75; stroke: #18232e; stroke-width: .8; }
footer { margin: 0 4px; color: var(--muted); font-size: 12.5px; }
@media screen and (max-width: 760px) {
  main { padding: 18px 10px 32px; }
  section { padding: 18px 16px 20px; }
  h1 { font-size: 23px; }
  .headline { font-size: 27px; }
  .charts, .charts.three { grid-template-columns: 1fr; }
  .columns { grid-template-columns: 1fr; }
  .bars { gap: 6px 10px; font-size: 13px; }
  .statistics tbody th { position: sticky; left: 0; background: #fff; }
}
.raw a { font-weight: 600; color: #0b5a8f; }
@page { size: A4; margin: 14mm 13mm; }
@media print {
  body { background: #fff; font-size: 10pt; }
  main { max-width: none; padding: 0; }
  section { border: 0; border-top: 1px solid var(--line); border-radius: 0; padding: 12px 0 8px; margin: 0 0 8px; }
  section.points, section.clouds, section + .part { break-before: page; }
  p, li, tr, h2, h3 { break-inside: avoid; }
  p, .badges, .verdict, .bars { font-size: 9pt; }
  .note { font-size: 8.4pt; }
  .screen, .cloud input, .cloud label { display: none; }
  .views, #cloud0:checked ~ .views { display: block; break-inside: avoid; margin-bottom: 10px; }
  .views .charts { grid-template-columns: 1fr 1fr; }
  .whole { break-inside: avoid; }
  .scroll { overflow: visible; }
  table { font-size: 7.6pt; }
  thead th { font-size: 7.4pt; }
  th, td { padding: 2.4px 5px; }
  tbody th.rows { padding-top: 9px; }
  td.first, th.first { padding-left: 10px; }
  .charts { gap: 12px 22px; grid-template-columns: 1fr 1fr; }
  .charts.three { grid-template-columns: 1fr 1fr 1fr; }
  h2, h3 { break-after: avoid; }
  .note:not(:last-child) { break-after: avoid; }
  tbody, .chart, .bars, .charts.three { break-inside: avoid; }
  .layers tbody { break-inside: auto; }
  .layers tbody tr:first-child { break-after: avoid; }
  .headline { font-size: 30px; }
  thead { display: table-header-group; }
}
)css";

}  // namespace truepose::report
