#include "app/output/report_style.h"

namespace pathfit::app {

std::string_view ReportStyle() {
  return R"css(
:root{color-scheme:light dark;--bg:#f5f6f8;--card:#fff;--ink:#1b2230;--soft:#5a6577;
--line:#dde2ea;
--grid:#e8ebf0;--accent:#1f5fd0;--good:#167a45;--goodbg:#e5f5ec;--warn:#8a5300;--warnbg:#fff4de;
--bad:#b3231b;--badbg:#fdeae8;--s0:#1f5fd0;--s1:#d9720a;--s2:#1f9254;--s3:#8250c8;--s4:#c8334e;
--s5:#178a9c}
@media (prefers-color-scheme:dark){:root{--bg:#12151b;--card:#1b2029;--ink:#e6e9ef;--soft:#9aa5b6;
--line:#303846;--grid:#272e3a;--accent:#7aa7ff;--good:#6fd39b;--goodbg:#16301f;--warn:#f0bd6a;
--warnbg:#33270f;--bad:#ff8d84;--badbg:#3a1a18;--s0:#7aa7ff;--s1:#f2a14b;--s2:#63c98f;
--s3:#bb98f0;
--s4:#f2788c;--s5:#5fc4d3}}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--ink);font:15px/1.5 system-ui,-apple-system,
"Segoe UI",
Roboto,"Helvetica Neue",Arial,sans-serif}
main{max-width:1200px;margin:0 auto;padding:28px 20px 60px}
h1{font-size:26px;line-height:1.2;margin:0;overflow-wrap:anywhere}
h2{font-size:18px;margin:36px 0 12px}
h3{font-size:15px;margin:0;overflow-wrap:anywhere}
p{margin:6px 0}
.sub,.note,.numbers,figcaption{color:var(--soft);font-size:13px}
header .sub{margin:4px 0 18px;overflow-wrap:anywhere}
nav{display:flex;flex-wrap:wrap;gap:4px 16px;font-size:13px;margin:14px 0 0}
a{color:var(--accent);text-decoration:none}a:hover{text-decoration:underline}
.card{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:16px 18px;
margin:0 0 14px}
.verdict{border-left:6px solid var(--soft)}
.verdict.finished{border-left-color:var(--good)}
.verdict.stopped,.verdict.running{border-left-color:var(--warn)}
.verdict.failed,.verdict.killed{border-left-color:var(--bad)}
.badge{display:inline-block;border-radius:999px;padding:1px 11px;font-weight:600;font-size:13px;
background:var(--grid);color:var(--soft)}
.finished .badge{background:var(--goodbg);color:var(--good)}
.stopped .badge,.running .badge{background:var(--warnbg);color:var(--warn)}
.failed .badge,.killed .badge{background:var(--badbg);color:var(--bad)}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(170px,1fr));gap:10px;
margin:14px 0 4px}
.tile{background:var(--bg);border-radius:8px;padding:10px 14px}
.tile b{display:block;font-size:21px;line-height:1.3;font-variant-numeric:tabular-nums}
.tile span{color:var(--soft);font-size:12.5px}
.tile i{font-style:normal;margin-left:4px}.tile .up{color:var(--good)}
.tile .down{color:var(--bad)}
ul.warnings{list-style:none;margin:12px 0 0;padding:0}
ul.warnings li{background:var(--warnbg);color:var(--warn);border-radius:6px;padding:6px 12px;
margin:6px 0;
overflow-wrap:anywhere}
ul.plain{margin:0;padding-left:20px}ul.plain li{margin:3px 0;overflow-wrap:anywhere}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:13.5px;font-variant-numeric:tabular-nums}
th,td{text-align:right;padding:6px 10px;border-bottom:1px solid var(--line);white-space:nowrap}
th{color:var(--soft);font-weight:600;font-size:12.5px;vertical-align:bottom}
th:first-child,td:first-child,.left{text-align:left}
tbody tr:last-child td{border-bottom:0}
td.wrap{white-space:normal;min-width:160px;overflow-wrap:anywhere}
.tag{display:inline-block;border-radius:4px;padding:0 7px;font-size:12px;font-weight:600;
background:var(--grid);
color:var(--soft)}
.tag.val{background:var(--warnbg);color:var(--warn)}.tag.bound{background:var(--badbg);
color:var(--bad)}
.view .head{display:flex;flex-wrap:wrap;gap:4px 12px;align-items:baseline;margin-bottom:10px}
.row{display:grid;grid-template-columns:repeat(5,1fr);gap:10px}
.row figure{margin:0;min-width:0}
.row img,.zoomed{width:100%;height:auto;display:block;border-radius:6px;background:var(--grid)}
.row img{border:1px solid var(--line)}
.row .none{aspect-ratio:4/3;border-radius:6px;background:var(--grid);display:grid;
place-items:center;
color:var(--soft);font-size:12.5px;text-align:center;padding:8px}
.js .row img{cursor:zoom-in}.zoom{margin:0 0 10px}.zoom img{max-width:min(100%,900px);
cursor:zoom-out}
.scale{display:flex;align-items:center;gap:8px;font-size:12.5px;color:var(--soft);flex-wrap:wrap}
.ramp{display:inline-block;width:220px;height:12px;border-radius:3px;
background:linear-gradient(90deg,#2159d9,#fff 50%,#db2621)}
.sw{display:inline-block;width:12px;height:12px;border-radius:3px;vertical-align:-1px;
margin:0 4px 0 10px}
.sw.both{background:#b8b8b8}.sw.fit{background:#db2621}.sw.mask{background:#2159d9}
.sw.s0{background:var(--s0)}.sw.s1{background:var(--s1)}
.plots{display:grid;grid-template-columns:repeat(2,1fr);gap:14px}
.plot{margin:0;background:var(--card);border:1px solid var(--line);border-radius:10px;
padding:12px 14px;min-width:0}
.plot.wide{margin:0 0 14px}
.plot figcaption{display:flex;flex-wrap:wrap;gap:2px 14px;align-items:baseline}
.plot figcaption b{color:var(--ink);font-size:14px;margin-right:auto}
.plot svg{width:100%;height:auto;display:block;margin-top:6px}
.empty{color:var(--soft);text-align:center;padding:40px 0}
.key::before{content:"";display:inline-block;width:16px;height:3px;border-radius:2px;
background:currentColor;
margin-right:6px;vertical-align:3px}
.key.dashed::before{background:repeating-linear-gradient(90deg,currentColor 0 5px,
transparent 5px 8px)}
.key.reject{color:var(--bad)}.key.reject::before{display:none}
.key.s0{color:var(--s0)}.key.s1{color:var(--s1)}.key.s2{color:var(--s2)}.key.s3{color:var(--s3)}
.key.s4{color:var(--s4)}.key.s5{color:var(--s5)}
svg text{font-size:11px;fill:var(--soft);font-family:inherit;font-variant-numeric:tabular-nums}
svg .end{text-anchor:end}svg .mid{text-anchor:middle}
svg .grid{stroke:var(--grid);fill:none}svg .axis{stroke:var(--soft);fill:none}
svg .stage{stroke:var(--soft);stroke-dasharray:2 3;fill:none}
svg .line{fill:none;stroke-width:2;stroke-linejoin:round}svg .dashed{stroke-dasharray:6 4}
svg .cross{fill:none;stroke:var(--bad);stroke-width:1.6}
svg .line.s0{stroke:var(--s0)}svg .line.s1{stroke:var(--s1)}svg .line.s2{stroke:var(--s2)}
svg .line.s3{stroke:var(--s3)}svg .line.s4{stroke:var(--s4)}svg .line.s5{stroke:var(--s5)}
svg .dot.s0,svg .bar.s0{fill:var(--s0)}svg .dot.s1,svg .bar.s1{fill:var(--s1)}
svg .dot.s2,svg .bar.s2{fill:var(--s2)}svg .dot.s3,svg .bar.s3{fill:var(--s3)}
svg .dot.s4,svg .bar.s4{fill:var(--s4)}svg .dot.s5,svg .bar.s5{fill:var(--s5)}
.pair{display:grid;grid-template-columns:repeat(2,1fr);gap:14px}.pair figure{margin:0}
.pair img{width:100%;image-rendering:pixelated;border-radius:6px;display:block}
details{margin:8px 0}summary{cursor:pointer;color:var(--accent);font-size:14px}
pre{background:var(--bg);border-radius:6px;padding:12px 14px;overflow:auto;max-height:520px;
font-size:12.5px;
line-height:1.45;white-space:pre-wrap;overflow-wrap:anywhere}
code{font-size:12.5px;overflow-wrap:anywhere}td code{white-space:normal}
@media (max-width:760px){.row{grid-template-columns:repeat(2,1fr)}.plots,
.pair{grid-template-columns:1fr}}
@media print{:root{color-scheme:light;--bg:#fff;--card:#fff;--ink:#000;--soft:#444;--line:#bbb;
--grid:#ddd}
body{font-size:11pt}main{max-width:none;padding:0}nav,.zoom{display:none}
.card,.plot,.view,tr{break-inside:avoid}h2{break-after:avoid}pre{max-height:none}
.ramp,.sw,.tag,.badge,.tile{print-color-adjust:exact;-webkit-print-color-adjust:exact}}
)css";
}

std::string_view ReportScript() {
  // Pictures of one view appear large in the same place, so that going from one to the next shows
  // what differs.
  return R"js(
document.documentElement.classList.add("js");
for (const row of document.querySelectorAll(".row")) {
  const show = (image) => {
    let zoom = row.previousElementSibling;
    if (!zoom || !zoom.classList.contains("zoom")) {
      zoom = document.createElement("div");
      zoom.className = "zoom";
      const large = document.createElement("img");
      large.className = "zoomed";
      large.addEventListener("click", () => zoom.remove());
      zoom.append(large);
      row.before(zoom);
    }
    zoom.firstChild.src = image.src;
    zoom.firstChild.alt = image.alt;
  };
  for (const image of row.querySelectorAll("img")) {
    image.tabIndex = 0;
    image.title = "Click to enlarge; click another one to compare in place";
    image.addEventListener("click", () => show(image));
    image.addEventListener("keydown", (event) => { if (event.key === "Enter") show(image); });
  }
}
)js";
}

}  // namespace pathfit::app
