// Life left and the next change, of a machine or the whole shop, the soonest first.
import { useTranslation } from "react-i18next";
import { duration } from "../../format/time";
import { address } from "../../shell/router";
import { Button, Progress } from "../../ui/parts";
import type { LifeGroup } from "./types";

const amount = (value: number, unit: LifeGroup["unit"]) => (unit === "uses" ? String(value) : duration(value));

export function ToolLifeTable({ groups, shopWide, may, onEdit }: {
  groups: LifeGroup[]; shopWide?: boolean; may?: boolean; onEdit?: (what: string, before: number, after: number) => void;
}) {
  const { t } = useTranslation();
  return (
    <div className="table-box">
      <table className="table tool-life"><thead><tr>{shopWide && <th>{t("alarms.machine")}</th>}<th>{t("data.group")}</th><th>{t("data.life_left")}</th><th className="right">{t("data.left_all")}</th>
        <th className="right">{t("data.parts_left")}</th><th className="right">{t("data.next_change")}</th>{!shopWide && <th>{t("data.tools")}</th>}</tr></thead>
        <tbody>{groups.map((one) => (
          <tr key={`${one.machine}/${one.group}`} data-life={`${one.machine}/${one.group}`}>
            {shopWide && <td><a href={address(["data", one.machine], { tab: "tool_life" })}>{one.machine_name}</a></td>}
            <td className="num">{one.group}</td>
            <td className="life-bar"><Progress part={one.life > 0 ? one.left_current / one.life : null} state={one.change_due ? "alarm" : one.notice ? "hold" : "running"} label={t("data.life_left")} />
              <span className="num">{amount(one.left_current, one.unit)} / {amount(one.life, one.unit)}</span></td>
            <td className="num right">{amount(one.left_total, one.unit)}</td>
            <td className="num right">{one.parts_left === null ? "–" : Math.floor(one.parts_left)}</td>
            <td className="num right">{one.change_due ? <span className="chip bad">{t("data.change_now")}</span> : one.next_change_s === null ? "–" : duration(one.next_change_s)}{one.notice && !one.change_due && <span className="chip warn">{t("data.notice")}</span>}</td>
            {!shopWide && <td><ul className="life-tools">{one.tools.map((tool, i) => (
              <li key={i} data-life-tool={i}><b className="mono">{tool.mark || "\u00a0"}</b> T{tool.tool} {tool.offset > 0 && <>· {t("machine.offset")} {tool.offset}</>}{tool.h > 0 && <> H{tool.h} D{tool.d}</>}
                <span className="num"> {amount(tool.used, one.unit)}</span>
                {may && onEdit && <>
                  <Button small kind="quiet" data-action="new-tool" disabled={tool.used === 0} onClick={() => onEdit(`tool_life/${one.group}/used/${i}`, tool.used, 0)}>{t("data.new_tool")}</Button>
                  <Button small kind="quiet" data-action="skip" onClick={() => onEdit(`tool_life/${one.group}/skipped/${i}`, tool.mark === "#" ? 1 : 0, tool.mark === "#" ? 0 : 1)}>{t(tool.mark === "#" ? "data.unskip" : "data.skip")}</Button></>}
              </li>))}</ul></td>}
          </tr>))}</tbody></table>
      {groups.length === 0 && <div className="empty small">{t("data.no_groups")}</div>}
    </div>
  );
}
