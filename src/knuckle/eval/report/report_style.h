// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace knuckle {

/// The report's style sheet, for light and dark screens and for paper. The attribute selectors at the end
/// give the figures' ink (gnuplot writes colours as attributes) the page's own.
inline constexpr std::string_view kReportStyle = R"css(
:root { color-scheme: light dark; --paper: #ffffff; --ink: #1d1d24; --soft: #62626e; --line: #dcdce2; --card: #f7f7f9;
  --best: #e3f1ea; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #16161b; --ink: #ececf1; --soft: #a3a3b0; --line: #34343e; --card: #1f1f26; --best: #1d3a2d; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2.5rem 1.5rem 4rem; max-width: 75rem; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { margin: 0 0 .5rem; font-size: 1.9rem; line-height: 1.2; overflow-wrap: anywhere; }
* + h1 { margin-top: 4.5rem; }
h2 { margin: 2.8rem 0 .8rem; font-size: 1.3rem; }
h3 { margin: 1.6rem 0 .5rem; font-size: 1rem; font-weight: 600; overflow-wrap: anywhere; }
p, li, dd { max-width: 48rem; }
.soft, figcaption, .note { color: var(--soft); font-size: .875rem; }
dl.facts { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1.2rem; margin: 1rem 0 0; }
dl.facts dt { color: var(--soft); }
dl.facts dd { margin: 0; overflow-wrap: anywhere; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .5rem .7rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { color: var(--soft); font-size: .8rem; font-weight: 600; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; white-space: normal; overflow-wrap: anywhere; min-width: 9rem; }
td.best { font-weight: 700; background: var(--best); }
.swatch { display: inline-block; width: .8em; height: .8em; margin-right: .5em; border-radius: 2px; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); gap: 1.2rem; }
.figures .wide { grid-column: 1 / -1; }
.figures.single { max-width: 36rem; margin-top: 1.2rem; }
figure { margin: 0; }
.figures figure { padding: 1rem; background: var(--card); border: 1px solid var(--line); border-radius: .5rem; }
.figures svg { display: block; width: 100%; height: auto; }
.gallery { display: flex; flex-wrap: wrap; gap: 0 1.1rem; --picture: 17rem; --gap: .8rem; }
.frame { width: min(100%, calc(var(--pictures) * (var(--picture) + var(--gap)) - var(--gap))); }
.pictures { display: flex; flex-wrap: wrap; gap: var(--gap); }
.pictures figure { width: min(100%, var(--picture)); }
.pictures img { display: block; width: 100%; border-radius: .4rem; }
.pictures figcaption { display: flex; justify-content: space-between; gap: .8rem; padding: .3rem .1rem 0;
  overflow-wrap: anywhere; }
.pictures figcaption span:last-child { white-space: nowrap; }
table.texts th, table.texts td { text-align: left; white-space: normal; vertical-align: top; }
table.texts td:first-child { width: 24rem; }
.verdict { font-weight: 700; }
table.texts td.verdict { white-space: nowrap; }
.agrees { color: #009e73; }
.in-part { color: #c98500; }
.disagrees { color: #d55e00; }
.not-known { color: var(--soft); }
.warning { padding: .7rem 1rem; border-left: .3rem solid #e69f00; background: var(--card); }
code { font-size: .9em; }
details { margin-top: 1rem; }
summary { cursor: pointer; font-weight: 600; }
.figures svg [font-family] { font-family: inherit; }
.figures svg [fill="rgb(51,51,51)"] { fill: var(--ink); }
.figures svg [stroke="rgb( 51,  51,  51)"] { stroke: var(--soft); }
.figures svg .gridline { stroke: var(--line); }
@media print { .figures figure, .frame, tr { break-inside: avoid; } }
)css";

}  // namespace knuckle
