%
O0001 (naca_blade__pressure_sid)
(evencut)
(job: naca blade, pressure side)
(tool 1: bull end mill, diameter 10.0000 corner radius 1.0000)
(mm, tool tip programmed)
(planned for table A about X that carries table C about Z, centre at program zero)
(workpiece coordinates: they turn with the table, tool centre control on)
G21 G90 G17 G94 G40 G49 G80
G91 G28 Z0.
G90
T1 M6
S8000 M3
G0 A-17.4801 C83.4815
G43.4 H1
G93
X-61.1458 Y-3.6366 Z108.8262 A-17.4801 C83.4815
G1 X-25.7546 Y0.4073 Z-4.2874 F25.297
X-25.7405 Y0.2140 Z-4.3129 A-17.4938 C83.5811 F6139.985
X-25.6782 Y0.0289 Z-4.3211 A-17.4557 C83.6787 F6130.521
X-25.5717 Y-0.1355 Z-4.3118 A-17.3682 C83.7682 F6120.917
X-25.4283 Y-0.2678 Z-4.2861 A-17.2374 C83.8444 F6096.380
X-25.2577 Y-0.3593 Z-4.2475 A-17.1145 C83.8306 F6078.663
X-25.0714 Y-0.4034 Z-4.1980 A-16.9724 C83.7857 F6068.497
G49
M5
G91 G28 Z0.
G90
M30
%
