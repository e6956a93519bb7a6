// When the shop works, and what stops are called. For setters.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { get, list, patch, post, remove } from "../../api/client";
import type { Calendar, DowntimeReason, Shift } from "../../api/types";
import { inLanguage } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field, Tabs, toast, useAction } from "../../ui/parts";

const weekdays = [1, 2, 3, 4, 5, 6, 7] as const;

export function ShiftsDialog({ onClose, onChanged }: { onClose: () => void; onChanged: () => void }) {
  const { t } = useTranslation();
  const [tab, setTab] = useState<"shifts" | "reasons">("shifts");
  const { value: calendar, error } = useLoad((signal) => get<Calendar>("/calendar", signal), []);
  const [edited, setEdited] = useState<Calendar | null>(null);
  const { busy, run } = useAction();
  const now = edited ?? calendar;
  const save = () => run(async () => {
    if (now) await patch("/calendar", now);
    toast("good", t("times.shifts_kept"));
    onChanged();
    onClose();
  });
  return (
    <Dialog wide name="shifts" title={t("times.settings")} onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      {tab === "shifts" && <Button kind="primary" busy={busy} disabled={!edited || !edited.time_zone || edited.shifts.some((shift) => !shift.name.trim() || shift.days.length === 0)} onClick={save}>{t("common.save")}</Button>}</>}>
      <Tabs label={t("times.settings")} value={tab} onChange={setTab} options={[{ value: "shifts", text: t("times.shifts") }, { value: "reasons", text: t("times.reasons") }]} />
      <ErrorNote error={error} />
      {tab === "shifts" && now && <Shifts calendar={now} onChange={setEdited} />}
      {tab === "reasons" && <Reasons onChanged={onChanged} />}
    </Dialog>
  );
}

function Shifts({ calendar, onChange }: { calendar: Calendar; onChange: (calendar: Calendar) => void }) {
  const { t } = useTranslation();
  const change = (at: number, changed: Partial<Shift>) =>
    onChange({ ...calendar, shifts: calendar.shifts.map((shift, i) => (i === at ? { ...shift, ...changed } : shift)) });
  return (
    <>
      <Field label={t("times.time_zone")} hint={t("times.time_zone_hint")}>
        <input name="time_zone" list="time-zones" value={calendar.time_zone} onChange={(event) => onChange({ ...calendar, time_zone: event.target.value })} /></Field>
      <datalist id="time-zones">{["Asia/Shanghai", "Asia/Tokyo", "Asia/Kolkata", "Europe/Berlin", "Europe/London", "America/New_York", "America/Chicago", "Etc/UTC"].map((zone) => <option key={zone} value={zone} />)}</datalist>
      {calendar.shifts.length === 0 && <p className="dim">{t("times.no_shifts")}</p>}
      {calendar.shifts.map((shift, at) => (
        <div className="shift-row" key={at} data-shift={at}>
          <input name="name" aria-label={t("times.shift_name")} placeholder={t("times.shift_name")} value={shift.name} onChange={(event) => change(at, { name: event.target.value })} />
          <input type="time" name="start" aria-label={t("times.shift_start")} value={shift.start} onChange={(event) => change(at, { start: event.target.value || shift.start })} />
          <input type="time" name="end" aria-label={t("times.shift_end")} value={shift.end} onChange={(event) => change(at, { end: event.target.value || shift.end })} />
          <span className="weekdays">{weekdays.map((day) => (
            <button key={day} type="button" aria-pressed={shift.days.includes(day)} onClick={() => change(at, { days: shift.days.includes(day) ? shift.days.filter((one) => one !== day) : [...shift.days, day].sort() })}>{t(`weekday.${day}`)}</button>))}</span>
          <Button small kind="quiet" icon="trash" aria-label={t("common.remove")} onClick={() => onChange({ ...calendar, shifts: calendar.shifts.filter((_, i) => i !== at) })} />
        </div>))}
      <div><Button small icon="plus" data-action="add-shift" onClick={() => onChange({ ...calendar, shifts: [...calendar.shifts, { name: "", days: [1, 2, 3, 4, 5], start: "08:00", end: "17:00" }] })}>{t("times.add_shift")}</Button></div>
    </>
  );
}

function Reasons({ onChanged }: { onChanged: () => void }) {
  const { t } = useTranslation();
  const { value: reasons, error, reload } = useLoad((signal) => list<DowntimeReason>("/downtime-reasons", signal), []);
  const [made, setMade] = useState({ name_zh: "", name_en: "", planned: false });
  const { busy, run } = useAction();
  const done = () => { reload(); onChanged(); };
  return (
    <>
      <ErrorNote error={error} />
      <table className="table"><tbody>
        {(reasons ?? []).map((reason) => (
          <tr key={reason.id}><td>{inLanguage(reason.name)}</td><td className="dim">{reason.name.zh} · {reason.name.en}</td>
            <td><label className="check"><input type="checkbox" checked={reason.planned} disabled={busy} onChange={(event) => run(async () => {
              await patch(`/downtime-reasons/${reason.id}`, { name_en: reason.name.en, name_zh: reason.name.zh, planned: event.target.checked });
              done();
            })} />{t("times.planned_short")}</label></td>
            <td className="row-actions"><Button small kind="quiet" icon="trash" busy={busy} aria-label={t("common.remove")} onClick={() => run(async () => { await remove(`/downtime-reasons/${reason.id}`); done(); })} /></td></tr>))}
      </tbody></table>
      <div className="shift-row">
        <input aria-label={t("times.reason_zh")} placeholder={t("times.reason_zh")} value={made.name_zh} onChange={(event) => setMade({ ...made, name_zh: event.target.value })} />
        <input aria-label={t("times.reason_en")} placeholder={t("times.reason_en")} value={made.name_en} onChange={(event) => setMade({ ...made, name_en: event.target.value })} />
        <label className="check"><input type="checkbox" checked={made.planned} onChange={(event) => setMade({ ...made, planned: event.target.checked })} />{t("times.planned_short")}</label>
        <Button small icon="plus" busy={busy} disabled={!made.name_zh.trim() || !made.name_en.trim()} onClick={() => run(async () => {
          await post("/downtime-reasons", made);
          setMade({ name_zh: "", name_en: "", planned: false });
          done();
        })}>{t("times.add_reason")}</Button>
      </div>
    </>
  );
}
