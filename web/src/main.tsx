import { StrictMode } from "react";
import { createRoot } from "react-dom/client";
import "./i18n";
import "./style/base.css";
import "./style/controls.css";
import "./style/floor.css";
import "./style/machine.css";
import "./style/times.css";
import "./style/data.css";
import "./style/programs.css";
import { App } from "./shell/App";

const root = document.getElementById("root");
if (!root) throw new Error("index.html has no #root");
createRoot(root).render(<StrictMode><App /></StrictMode>);
