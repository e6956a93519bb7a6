// What a paste, a file, another machine or a moment would change, before it is taken over into the page.
import { useTranslation } from "react-i18next";
import { reasonText } from "../../i18n";
import { Button, Dialog, Note } from "../../ui/parts";
import { shown } from "./grid";
import type { SheetRow, ValueItem } from "./types";

export function Preview({ title, rows, without, onClose, onTake }: {
  title: string; rows: (ValueItem & Partial<SheetRow>)[]; without?: number; onClose: () => void; onTake: (rows: ValueItem[]) => void;
}) {
  const { t } = useTranslation();
  const wrong = rows.filter((row) => row.problem);
  return (
    <Dialog title={title} name="preview" wide onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" disabled={wrong.length > 0 || rows.length === 0} data-action="take" onClick={() => onTake(rows)}>{t("data.take", { count: rows.length })}</Button></>}>
      {wrong.length > 0 && <Note kind="error">{t("data.wrong_cells", { count: wrong.length })}</Note>}
      {!!without && <Note kind="warn">{t("data.without_place", { count: without })}</Note>}
      {rows.length === 0 && <Note>{t("data.no_difference")}</Note>}
      <div className="table-box preview"><table className="table"><thead><tr><th>{t("data.value")}</th><th className="right">{t("data.now")}</th><th className="right">{t("data.new")}</th><th /></tr></thead>
        <tbody>{[...wrong, ...rows.filter((row) => !row.problem)].slice(0, 1000).map((row, i) => (
          <tr key={i} data-preview={row.what} className={row.problem ? "wrong" : ""}>
            <td className="mono">{row.what}</td><td className="num right">{shown(row.before) || "–"}</td><td className="num right">{row.problem ? row.text : shown(row.after) || "–"}</td>
            <td>{row.problem ? t("data.in_line", { line: row.line ?? 0, reason: problemText(row.problem, t) }) : ""}</td></tr>))}</tbody></table></div>
    </Dialog>
  );
}

const problemText = (problem: string, t: (key: string) => string) => (problem === "not_a_number" ? t("data.not_a_number") : reasonText(problem));
