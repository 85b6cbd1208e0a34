"""Style and behaviour of the page: light, dark, paper, narrow screens, keyboard."""

STYLE = """
:root{color-scheme:light dark;--paper:#ffffff;--ink:#1c2430;--quiet:#556070;--line:#d5dbe3;--box:#f3f6fa;
--named:#1c7ed6;--none:#2f9e44;--unknown:#d9480f}
@media (prefers-color-scheme:dark){:root{--paper:#14181f;--ink:#e6eaf0;--quiet:#a3adbb;--line:#333c49;--box:#1c222c;
--named:#4dabf7;--none:#69db7c;--unknown:#ff922b}}
*{box-sizing:border-box}
body{font:16px/1.5 system-ui,sans-serif;max-width:1180px;margin:0 auto;padding:1.2rem;color:var(--ink);
background:var(--paper)}
h1{font-size:1.05rem;font-weight:600;color:var(--quiet);margin:0 0 .5rem}
h2{font-size:1.3rem;margin:2.4rem 0 .6rem;padding-top:.6rem;border-top:1px solid var(--line)}
h3{font-size:1.08rem;margin:1.4rem 0 .3rem}p{margin:.4rem 0 .7rem;max-width:52rem}
.verdict{font-size:1.55rem;line-height:1.25;font-weight:650;border-left:7px solid var(--tone);
padding:.2rem 0 .2rem .9rem;margin:0 0 1rem}
.badge{display:inline-block;font-size:.8rem;font-weight:700;letter-spacing:.04em;color:var(--tone);
border:1.5px solid var(--tone);border-radius:4px;padding:.02rem .45rem;margin-right:.6rem;vertical-align:.28rem}
.named{--tone:var(--named)}.none{--tone:var(--none)}.unknown{--tone:var(--unknown)}
.first{display:grid;grid-template-columns:minmax(0,5fr) minmax(0,6fr);gap:1.6rem;align-items:start}
dl.facts{margin:0}dl.facts dt{font-weight:650;margin-top:.75rem}dl.facts dt:first-child{margin-top:0}
dl.facts dd{margin:.1rem 0 0}dl.facts dd ul{margin:.1rem 0;padding-left:1.1rem}
.sub{color:var(--quiet);font-size:.92rem}figure{margin:.4rem 0 1rem}
figcaption{color:var(--quiet);font-size:.92rem;max-width:56rem}
table{border-collapse:collapse;margin:.4rem 0 1rem}.wide{overflow-x:auto}
td,th{padding:.28rem .7rem .28rem 0;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}
th{font-weight:600}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
code{background:var(--box);padding:.1rem .35rem;border-radius:3px;overflow-wrap:anywhere}
details{margin:.4rem 0 1rem}summary{cursor:pointer;font-weight:600}
nav{font-size:.92rem;margin:1.4rem 0 0}nav a{margin-right:1rem;white-space:nowrap}a{color:var(--named)}
.tools{display:flex;gap:.5rem;margin:.3rem 0}
button{font:inherit;font-size:.9rem;color:var(--ink);background:var(--box);border:1px solid var(--line);
border-radius:4px;padding:.2rem .7rem;cursor:pointer}
a:focus-visible,button:focus-visible,summary:focus-visible{outline:3px solid var(--named);outline-offset:2px}
.js-plotly-plot .cartesianlayer text,.js-plotly-plot .infolayer text{fill:var(--ink) !important}
.js-plotly-plot .gridlayer path{stroke:var(--line) !important}
@media (max-width:860px){.first{grid-template-columns:minmax(0,1fr)}.verdict{font-size:1.3rem}}
@media print{:root{color-scheme:light;--paper:#fff;--ink:#000;--quiet:#333;--line:#bbb;--box:#f3f6fa;
--named:#1864ab;--none:#2b8a3e;--unknown:#d9480f}body{max-width:none;padding:0;font-size:11pt}
nav,.tools,.modebar-container{display:none !important}figure,table,.verdict{break-inside:avoid}h2,h3{break-after:avoid}
.first{grid-template-columns:minmax(0,1fr)}}
"""

SCRIPT = """
for (const button of document.querySelectorAll('[data-zoom]')) button.addEventListener('click', () => {
  const plot = document.getElementById(button.dataset.zoom);
  const range = [Number(button.dataset.from), Number(button.dataset.to)];
  const change = {};
  for (const key of Object.keys(plot.layout)) {
    if (/^xaxis/.test(key)) change[key + '.range'] = range;
    if (/^yaxis/.test(key)) change[key + '.autorange'] = true;
  }
  Plotly.relayout(plot, change);
});
window.addEventListener('beforeprint', () => {
  for (const closed of document.querySelectorAll('details:not([open])')) closed.open = true;
  for (const plot of document.querySelectorAll('.js-plotly-plot')) Plotly.Plots.resize(plot);
});
"""
