/* gripline report, source 9b434b8c673db4747c0db6f9fdfc4001c35961ffe5024de6813b50251463322b; holds uPlot 1.6.32 (c) 2022 Leon Sorokin, MIT licence */
"use strict";(()=>{document.getElementById("app").textContent="report";})();
