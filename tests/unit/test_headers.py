"""Headers as laboratories write them, read without an option."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import microslip as ms

TIME = np.arange(80) / 20.0
MOVED = 20e-6 * np.sin(3.0 * TIME)
CHANNELS = {
    "x": MOVED,
    "f": 250.0 * np.cos(3.0 * TIME),
    "n": np.full(80, 500.0),
    "t": TIME,
    "cycle": np.floor(TIME),
    "other": np.ones(80),
}
FACTORS = {"um": 1e6, "nm": 1e9, "mm": 1e3, "m": 1.0, "N": 1.0, "kN": 1e-3, "mN": 1e3, "s": 1.0,
           "ms": 1e3, "-": 1.0}  # fmt: skip
# Lines above the rows; columns and their units; separator, and decimal sign.
HEADS = [
    ("Time: s,Displacement: mm,Force: N", "t s x mm f N"),
    ("T,X,Fx\nsec,mm,N", "t s x mm f N"),
    ("DISP_UM,Q_N,TIME_S", "x um f N t s"),
    ("x_um,Q_N", "x um f N"),
    ("x/mm,Ft/N,time/s", "x mm f N t s"),
    ("t/s,Weg [mm],Kraft [N]", "t s x mm f N"),
    ("t/s;s/mm;F_R/N", "t s x mm f N", ";"),
    ("t/s;s/mm;F_R/N", "t s x mm f N", ";", ","),
    ("time_s,disp_um,force_N,load_N", "t s x um f N n N"),
    ("Time (s),Displacement (um),Friction force (N),Clamp (kN)", "t s x um f N n kN"),
    ("時間(s),変位(µm),摩擦力(N),荷重(N)", "t s x um f N n N"),
    ("時間[s]\t変位[mm]\t摩擦力[N]", "t s x mm f N", "\t"),
    ("時間（s）,変位（um）,接線荷重（N）,押付荷重（N）", "t s x um f N n N"),
    ("経過時間[s],変位[um],せん断荷重[N],締付力[N]", "t s x um f N n N"),
    ("サイクル数,時間(s),変位(um),水平荷重(N),垂直荷重(N)", "cycle - t s x um f N n N"),
    ("変位(um),摩擦力(N),せん断応力(kN)", "x um f N other kN"),
    ("Time,Displacement,Force\n[s],[mm],[N]", "t s x mm f N"),
    ("Time,Displacement,Force\ns,mm,N", "t s x mm f N"),
    ("Time\tPosition\tFx\tFz\ns\tmm\tN\tN", "t s x mm f N n N", "\t"),
    ("Timestamp,X-Pos,Fx,Fz,\nsec,mm,N,N,\nStep No. 2", "t s x mm f N n N other -"),
    ("Timestamp,X-Pos,Fx,Fz\nsec,mm,N,N\nStep No. 1,,,", "t s x mm f N n N"),
    ("Time,Disp,Load,Friction\n(s),(um),(N),(N)\n,,,", "t s x um n N f N"),
    ("Time,Displacement,Force\n\n[s],[mm],[N]", "t s x mm f N"),
    ("Elapsed Time (sec),Stroke (mm),Load Cell (N)", "t s x mm f N"),
    ("Time (sec),LVDT (micron),Force (Newton)", "t s x um f N"),
    ("Zeit [s];Weg [µm];Reibkraft [N];Normalkraft [N]", "t s x um f N n N", ";", ","),
    (
        "Temps (s);Déplacement (µm);Effort tangentiel (N);Effort normal (N)",
        "t s x um f N n N",
        ";",
        ",",
    ),
    ("Time s,Disp mm,Force N", "t s x mm f N"),
    (
        "Time [s], Relative displacement [um], Tangential force [N], Normal force [N]",
        "t s x um f N n N",
    ),
    ("displacement_mm,tangential_force_kN,normal_force_kN", "x mm f kN n kN"),
    ("Displacement(um)  Force(N)", "x um f N", " "),
    ("# time[s] disp[m] force[N]", "t s x m f N", " "),
    ("% t (s)\tx (m)\tF (N)", "t s x m f N", "\t"),
    ("u [µm],T [N],N [N]", "x um f N n N"),
    ("u_um,T_N,N_N", "x um f N n N"),
    ("delta (µm),Q (N),P (N)", "x um f N n N"),
    ("slip_um,shear_N,normal_N", "x um f N n N"),
    ("Sliding displacement, mm;Friction force, N", "x mm f N", ";"),
    ("Rel. Disp. [um],Fric. Force [N]", "x um f N"),
    ("Time_ms,Displacement_nm,Force_mN", "t ms x nm f mN"),
    ("time.s.,disp.um.,force.N.", "t s x um f N"),
    ("FT [N],FN [N],s [mm]", "f N n N x mm"),
    ("TIME,DISP,FORCE\nS,UM,N", "t s x um f N"),
    ("Channel 1 Time [s],Channel 2 Displacement [mm],Channel 3 Force [kN]", "t s x mm f kN"),
    ('"Time (s)","Axial Displacement (mm)","Axial Force (kN)"', "t s x mm f kN"),
    (
        "Fretting test 12\nDate: 2021-03-04\n\nTime (s),Displacement (µm),Tangential Force (N)",
        "t s x um f N",
    ),
    ("Sample;F_t in N;s in µm", "other - f N x um", ";"),
    ("t[s],delta[µm],Q[N],P[N]", "t s x um f N n N"),
    ("Cycle,Time(s),Disp(um),Friction(N),COF", "cycle - t s x um f N other -"),
    ("Hub [mm]|Kraft [N]", "x mm f N", "|"),
    ("Time, s\tCrosshead, mm\tForce, N", "t s x mm f N", "\t"),
    ("Weg_mm;Reibkraft_N;Normalkraft_N;Zeit_s", "x mm f N n N t s", ";"),
    ("t_s,x_mm,Ft_N,Fn_N", "t s x mm f N n N"),
    ("POS_MM,FRICTION_N,NORMAL_N", "x mm f N n N"),
    # Read by their units alone, by the unit against the name, and the tangential of two.
    ("A [ms],B [mm],C [N],D [°C]", "t ms x mm f N other -"),
    ("Position [s],x [mm],Friction [°C],F [N]", "other - x mm cycle - f N"),
    ("t [s],T [N],x [m]", "t s f N x m"),
    ("Normal disp [um],Tangential disp [um],Tangential load [N]", "other - x um f N"),
    ("Commanded position [mm],Position [mm],Lateral force [N]", "other - x mm f N"),
]


@pytest.mark.parametrize("head", HEADS, ids=lambda head: head[0].replace("\n", " / "))
def test_ordinary_headers_need_no_option(head: tuple[str, ...], tmp_path: Path) -> None:
    lines, words, separator, decimal = (*head, ",", ".")[:4] if len(head) != 3 else (*head, ".")
    parts = words.split()
    columns = dict(zip(parts[::2], parts[1::2], strict=True))
    values = np.transpose([CHANNELS[name] * FACTORS[unit] for name, unit in columns.items()])
    rows = [separator.join(f"{v:.12g}".replace(".", decimal) for v in row) for row in values]
    path = tmp_path / "run.csv"
    path.write_text("\n".join([lines, *rows, ""]), encoding="utf-8")
    record = ms.Record.read(path)
    read = {"x": record.displacement, "f": record.force, "n": record.normal_load, "t": record.time}
    for name, got in read.items():
        if name in columns:
            np.testing.assert_allclose(got, CHANNELS[name], rtol=1e-9, atol=1e-15, err_msg=name)
