// The look of report.html: one column, light, readable on paper too.
#pragma once

namespace armsight::demo {

inline constexpr const char* kReportStyle = R"css(
:root{--ink:#1d252c;--soft:#4a5560;--line:#dfe4e8;--wash:#f5f7f9;--good:#00734f;--bad:#b34700;--accent:#0072B2}
*{box-sizing:border-box}
body{margin:0;color:var(--ink);background:#fff;font:15.5px/1.55 system-ui,"Segoe UI","DejaVu Sans",Helvetica,Arial,sans-serif}
main,header>div,footer>div{max-width:1120px;margin:0 auto;padding:0 28px}
header{background:var(--wash);border-bottom:1px solid var(--line);padding:34px 0 26px}
h1{font-size:30px;line-height:1.2;margin:0 0 6px;letter-spacing:-.01em}
h2{font-size:21px;margin:46px 0 6px;padding-top:14px;border-top:1px solid var(--line)}
h3{font-size:15.5px;margin:22px 0 4px}
p{margin:6px 0 12px;max-width:78ch}
.soft{color:var(--soft)}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(190px,1fr));gap:12px;margin:22px 0 0}
.tile{background:#fff;border:1px solid var(--line);border-radius:10px;padding:14px 16px}
.tile b{display:block;font-size:20px;line-height:1.25;letter-spacing:-.01em;font-variant-numeric:tabular-nums;white-space:nowrap}
.tile span{color:var(--soft);font-size:13.5px}
.tile .name{color:var(--ink);font-weight:600;font-size:13.5px}
.good{color:var(--good)}.bad{color:var(--bad)}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(430px,1fr));gap:18px;margin:14px 0}
figure{margin:0}
.figures>figure{border:1px solid var(--line);border-radius:10px;padding:12px;background:#fff}
.figures svg{width:100%;height:auto;display:block}
figure img{width:100%;display:block;border-radius:8px;border:1px solid var(--line)}
figcaption{font-size:13.5px;color:var(--soft);margin-top:6px}
.scroll{overflow-x:auto}
table{border-collapse:collapse;margin:10px 0 16px;font-size:14px;font-variant-numeric:tabular-nums}
th,td{padding:5px 14px 5px 0;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th{font-weight:600;color:var(--soft)}
th:first-child,td:first-child{text-align:left}
td.text,th.text{text-align:left;white-space:normal}
details{margin:8px 0;border:1px solid var(--line);border-radius:8px;background:var(--wash)}
summary{cursor:pointer;padding:8px 14px;font-weight:600;font-size:14px}
pre{margin:0;padding:10px 14px;overflow:auto;font:12.5px/1.5 ui-monospace,"DejaVu Sans Mono",Menlo,monospace;border-top:1px solid var(--line);background:#fff;border-radius:0 0 8px 8px}
code{font:13.5px ui-monospace,"DejaVu Sans Mono",Menlo,monospace;background:var(--wash);padding:1px 5px;border-radius:4px}
footer{margin-top:50px;padding:20px 0 40px;border-top:1px solid var(--line);color:var(--soft);font-size:13.5px}
@media(max-width:560px){.figures{grid-template-columns:1fr}main,header>div,footer>div{padding:0 16px}}
@media print{details{display:none}h2{break-after:avoid}figure{break-inside:avoid}header{background:#fff}}
)css";

}  // namespace armsight::demo
