<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="de" sourcelanguage="en">
 <context>
  <name>capture</name>
  <message>
   <source>reading the photograph</source>
   <translation>Foto wird gelesen</translation>
  </message>
  <message>
   <source>Before</source>
   <translation>Vorher</translation>
  </message>
  <message>
   <source>The photograph as it was taken, with handles to frame it</source>
   <translation>Das Foto wie aufgenommen, mit Griffen für den Bildausschnitt</translation>
  </message>
  <message>
   <source>After</source>
   <translation>Nachher</translation>
  </message>
  <message>
   <source>Calibrated, aligned and framed</source>
   <translation>Kalibriert, ausgerichtet und zugeschnitten</translation>
  </message>
  <message>
   <source>Near lamps</source>
   <translation>Nahe Lampen</translation>
  </message>
  <message>
   <source>How far away the lamps are, whose light falls off over the sample</source>
   <translation>Wie weit die Lampen entfernt sind, deren Licht über die Probe abfällt</translation>
  </message>
  <message>
   <source>Intensities</source>
   <translation>Intensitäten</translation>
  </message>
  <message>
   <source>How much the lamps differ in intensity</source>
   <translation>Wie stark sich die Lampen in der Intensität unterscheiden</translation>
  </message>
  <message>
   <source>Room light</source>
   <translation>Raumlicht</translation>
  </message>
  <message>
   <source>Light that is there whichever lamp is on</source>
   <translation>Licht, das unabhängig von der Lampe da ist</translation>
  </message>
  <message>
   <source>Camera</source>
   <translation>Kamera</translation>
  </message>
  <message>
   <source>Small shifts of the camera between photographs of lights all around</source>
   <translation>Kleine Verschiebungen der Kamera zwischen Fotos mit Licht von allen Seiten</translation>
  </message>
  <message>
   <source>List check</source>
   <translation>Listenprüfung</translation>
  </message>
  <message>
   <source>Whether the list of lights belongs to the photographs</source>
   <translation>Ob die Liste der Lichtrichtungen zu den Fotos gehört</translation>
  </message>
  <message>
   <source>In the reference and in a photograph that is not aligned correctly</source>
   <translation>Im Referenzfoto und in einem Foto, das nicht richtig ausgerichtet ist</translation>
  </message>
  <message>
   <source>Brightness of a matte white patch in the crossed photographs over that in the parallel ones</source>
   <translation>Helligkeit eines matten weißen Felds in den gekreuzten Fotos im Verhältnis zu den parallelen</translation>
  </message>
  <message>
   <source>Unknown</source>
   <translation>Unbekannt</translation>
  </message>
  <message>
   <source>Per pixel</source>
   <translation>Je Pixel</translation>
  </message>
  <message>
   <source>Size of a pixel of the photographs</source>
   <translation>Größe eines Pixels der Fotos</translation>
  </message>
  <message>
   <source>Between two points</source>
   <translation>Zwischen zwei Punkten</translation>
  </message>
  <message>
   <source>Distance of the two points: drag from the one to the other</source>
   <translation>Abstand der beiden Punkte: vom einen zum anderen ziehen</translation>
  </message>
  <message>
   <source>By the colour chart</source>
   <translation>Nach der Farbtafel</translation>
  </message>
  <message>
   <source>From the middle of one patch of the chart to that of the next</source>
   <translation>Von der Mitte eines Felds der Tafel zur Mitte des nächsten</translation>
  </message>
  <message>
   <source>Estimate by the camera</source>
   <translation>Schätzung nach Kamera</translation>
  </message>
  <message>
   <source>Estimate by distance</source>
   <translation>Schätzung nach Abstand</translation>
  </message>
  <message>
   <source>From the sample to the sensor of the camera, as measured</source>
   <translation>Von der Probe zum Sensor der Kamera, gemessen</translation>
  </message>
  <message>
   <source>Its outline, and the lamp's reflection in each photograph</source>
   <translation>Ihr Umriss und das Spiegelbild der Lampe in jedem Foto</translation>
  </message>
  <message>
   <source>All that they share</source>
   <translation>Schnittmenge</translation>
  </message>
  <message>
   <source>Crop</source>
   <translation>Ausschnitt</translation>
  </message>
  <message>
   <source>Four corners</source>
   <translation>Vier Ecken</translation>
  </message>
  <message>
   <source>Mark points…</source>
   <translation>Punkte setzen…</translation>
  </message>
  <message>
   <source>Points</source>
   <translation>Punkte</translation>
  </message>
  <message>
   <source>Calibration</source>
   <translation>Kalibrierung</translation>
  </message>
  <message>
   <source>Scale</source>
   <translation>Maßstab</translation>
  </message>
  <message>
   <source>Size of the sample, for heights and exports in millimetres</source>
   <translation>Größe der Probe, für Höhen und Exporte in Millimetern</translation>
  </message>
  <message>
   <source>Length</source>
   <translation>Länge</translation>
  </message>
  <message>
   <source>Mark the length…</source>
   <translation>Länge markieren…</translation>
  </message>
  <message>
   <source>Drag from one end of a known length to the other</source>
   <translation>Vom einen Ende einer bekannten Länge zum anderen ziehen</translation>
  </message>
  <message>
   <source>Ends</source>
   <translation>Endpunkte</translation>
  </message>
  <message>
   <source>Estimated</source>
   <translation>Geschätzt</translation>
  </message>
  <message>
   <source>From the pairs themselves</source>
   <translation>Aus den Paaren selbst</translation>
  </message>
  <message>
   <source>Stated</source>
   <translation>Angegeben</translation>
  </message>
  <message>
   <source>As measured on a matte white patch</source>
   <translation>Gemessen auf einem matten weißen Feld</translation>
  </message>
  <message>
   <source>Polarisers</source>
   <translation>Polfilter</translation>
  </message>
  <message>
   <source>How the crossed photographs of the pairs compare with the parallel ones</source>
   <translation>Verhältnis der gekreuzten Fotos der Paare zu den parallelen</translation>
  </message>
  <message>
   <source>Gain</source>
   <translation>Faktor</translation>
  </message>
  <message>
   <source>As stated</source>
   <translation>Wie angegeben</translation>
  </message>
  <message>
   <source>From capture.toml, an .lp file, the file names, or entered</source>
   <translation>Aus capture.toml, einer .lp-Datei, den Dateinamen oder eingegeben</translation>
  </message>
  <message>
   <source>Sphere</source>
   <translation>Kugel</translation>
  </message>
  <message>
   <source>Measured on a mirror sphere that is seen in the image</source>
   <translation>Gemessen an einer Spiegelkugel im Bild</translation>
  </message>
  <message>
   <source>Lights</source>
   <translation>Lichter</translation>
  </message>
  <message>
   <source>One</source>
   <translation>Eine</translation>
  </message>
  <message>
   <source>Gives the direction of each lamp</source>
   <translation>Ergibt die Richtung jeder Lampe</translation>
  </message>
  <message>
   <source>Two</source>
   <translation>Zwei</translation>
  </message>
  <message>
   <source>Give the positions of near lamps; the second is found in the image</source>
   <translation>Ergeben die Positionen naher Lampen; die zweite wird im Bild gefunden</translation>
  </message>
  <message>
   <source>Mirror spheres</source>
   <translation>Spiegelkugeln</translation>
  </message>
  <message>
   <source>Spheres</source>
   <translation>Kugeln</translation>
  </message>
  <message>
   <source>Correct by hand…</source>
   <translation>Von Hand korrigieren…</translation>
  </message>
  <message>
   <source>Distant, unless capture.toml says how near</source>
   <translation>Fern, sofern capture.toml keinen Abstand nennt</translation>
  </message>
  <message>
   <source>Near</source>
   <translation>Nah</translation>
  </message>
  <message>
   <source>The fall-off of its light over the sample is corrected</source>
   <translation>Der Abfall des Lichts über die Probe wird korrigiert</translation>
  </message>
  <message>
   <source>Lamp</source>
   <translation>Lampe</translation>
  </message>
  <message>
   <source>Distance</source>
   <translation>Abstand</translation>
  </message>
  <message>
   <source>Estimated from the photographs</source>
   <translation>Aus den Fotos geschätzt</translation>
  </message>
  <message>
   <source>The order and the axes in which the list of lights is taken</source>
   <translation>Reihenfolge und Achsen, in denen die Lichtliste gelesen wird</translation>
  </message>
  <message>
   <source>The photographs fit the list clearly better in this form</source>
   <translation>Die Fotos passen in dieser Form deutlich besser zur Liste</translation>
  </message>
  <message>
   <source>Light list</source>
   <translation>Lichtliste</translation>
  </message>
  <message>
   <source>Framing</source>
   <translation>Bildausschnitt</translation>
  </message>
  <message>
   <source>Width</source>
   <translation>Breite</translation>
  </message>
  <message>
   <source>Size</source>
   <translation>Größe</translation>
  </message>
  <message>
   <source>Of the image that is made</source>
   <translation>Des erzeugten Bildes</translation>
  </message>
  <message>
   <source>%1 × %2 px</source>
   <translation>%1 × %2 px</translation>
  </message>
  <message>
   <source>ΔE2000 %1 → %2</source>
   <translation>ΔE2000 %1 → %2</translation>
  </message>
  <message>
   <source>%1, largest %2</source>
   <translation>%1, größte %2</translation>
  </message>
  <message>
   <source>Used</source>
   <translation>Verwendet</translation>
  </message>
  <message>
   <source>Does not fit</source>
   <translation>Passt nicht</translation>
  </message>
  <message>
   <source>%1 point%2…</source>
   <translation>%1 Punkt…</translation>
  </message>
  <message>
   <source> and %1 more</source>
   <translation> und %1 weitere</translation>
  </message>
  <message>
   <source>%1%2 could not be aligned. Points marked by hand place %3.</source>
   <translation>%1%2 konnte nicht ausgerichtet werden. Von Hand gesetzte Punkte richten %3 aus.</translation>
  </message>
  <message>
   <source>The lights are not measured on a sphere</source>
   <translation>Die Lichtrichtungen werden nicht an einer Kugel gemessen</translation>
  </message>
  <message>
   <source>The gain is estimated from the pairs</source>
   <translation>Der Faktor wird aus den Paaren geschätzt</translation>
  </message>
  <message>
   <source>This scale needs no length</source>
   <translation>Dieser Maßstab braucht keine Länge</translation>
  </message>
  <message>
   <source>Needs lamps on several sides</source>
   <translation>Nur mit Lampen auf mehreren Seiten</translation>
  </message>
  <message>
   <source>What becomes the image: drag the handles on the photograph</source>
   <translation>Was zum Bild wird: die Griffe auf dem Foto ziehen</translation>
  </message>
  <message>
   <source>Only a near lamp has a distance</source>
   <translation>Nur eine nahe Lampe hat einen Abstand</translation>
  </message>
  <message>
   <source>From the middle of the sample to the lamp, in widths of the image</source>
   <translation>Von der Mitte der Probe zur Lampe, in Bildbreiten</translation>
  </message>
  <message>
   <source>Only a framed image has a size of its own</source>
   <translation>Nur ein zugeschnittenes Bild hat eine eigene Größe</translation>
  </message>
  <message>
   <source>Of the image that is made; its height follows</source>
   <translation>Des erzeugten Bildes; die Höhe folgt daraus</translation>
  </message>
  <message>
   <source>Draw an outline…</source>
   <translation>Umriss zeichnen…</translation>
  </message>
  <message>
   <source>Drawn outline</source>
   <translation>Gezeichneter Umriss</translation>
  </message>
  <message>
   <source>Choose a file…</source>
   <translation>Datei wählen…</translation>
  </message>
  <message>
   <source>%1 (fits better)</source>
   <translation>%1 (passt besser)</translation>
  </message>
  <message>
   <source>Take the list %1%2</source>
   <translation>Liste lesen: %1%2</translation>
  </message>
  <message>
   <source>White balance</source>
   <translation>Weißabgleich</translation>
  </message>
  <message>
   <source>Known length</source>
   <translation>Bekannte Länge</translation>
  </message>
  <message>
   <source>Object mask</source>
   <translation>Objektmaske</translation>
  </message>
  <message>
   <source>Gain of pairs</source>
   <translation>Faktor der Paare</translation>
  </message>
  <message>
   <source>Distance of the lamp</source>
   <translation>Abstand der Lampe</translation>
  </message>
  <message>
   <source>Estimates</source>
   <translation>Schätzungen</translation>
  </message>
  <message>
   <source>Blue: the other photographs predict this one. Red: they are the farthest from it. Hollow: excluded
Click a lamp to see its photograph; Ctrl adds one; draw a line round several to select them</source>
   <translation>Blau: die anderen Fotos sagen dieses voraus. Rot: am weitesten davon entfernt. Hohl: ausgeschlossen
Klick auf eine Lampe zeigt ihr Foto; mit Strg kommt eine hinzu; eine Linie um mehrere wählt diese aus</translation>
  </message>
  <message>
   <source>Lamps above the sample</source>
   <translation>Lampen über der Probe</translation>
  </message>
  <message>
   <source>
The other photographs predict it to %1</source>
   <translation>
Die anderen Fotos sagen es auf %1 genau voraus</translation>
  </message>
  <message>
   <source>
Excluded from the material</source>
   <translation>
Vom Material ausgeschlossen</translation>
  </message>
  <message>
   <source>%1
elevation %2°, azimuth %3°%4%5</source>
   <translation>%1
Elevation %2°, Azimut %3°%4%5</translation>
  </message>
  <message>
   <source>Azimuth</source>
   <translation>Azimut</translation>
  </message>
  <message>
   <source>Tolerance of the azimuth</source>
   <translation>Toleranz des Azimuts</translation>
  </message>
  <message>
   <source>Lowest elevation</source>
   <translation>Kleinste Elevation</translation>
  </message>
  <message>
   <source>Highest elevation</source>
   <translation>Größte Elevation</translation>
  </message>
  <message>
   <source>Use only these</source>
   <translation>Nur diese verwenden</translation>
  </message>
  <message>
   <source>Use all</source>
   <translation>Alle verwenden</translation>
  </message>
  <message>
   <source>Save the lights…</source>
   <translation>Lichter speichern…</translation>
  </message>
  <message>
   <source>For later captures under the same lamps</source>
   <translation>Für spätere Aufnahmen unter denselben Lampen</translation>
  </message>
  <message>
   <source>Elevation</source>
   <translation>Elevation</translation>
  </message>
  <message>
   <source>Lamps</source>
   <translation>Lampen</translation>
  </message>
  <message>
   <source>%1 of %2 selected</source>
   <translation>%1 von %2 ausgewählt</translation>
  </message>
  <message>
   <source>Select two lamps or more: click, or draw a line round them</source>
   <translation>Zwei oder mehr Lampen auswählen: anklicken oder mit einer Linie umfahren</translation>
  </message>
  <message>
   <source>These are the ones in use</source>
   <translation>Diese werden bereits verwendet</translation>
  </message>
  <message>
   <source>Leave all other photographs out of the material</source>
   <translation>Alle anderen Fotos vom Material ausschließen</translation>
  </message>
  <message>
   <source>All are in use</source>
   <translation>Alle werden verwendet</translation>
  </message>
  <message>
   <source>Leave no photograph out</source>
   <translation>Kein Foto ausschließen</translation>
  </message>
  <message>
   <source>Loupe</source>
   <translation>Lupe</translation>
  </message>
  <message>
   <source>Drag it, or move it by the arrow keys; the wheel magnifies. Z or Esc closes it</source>
   <translation>Ziehen oder mit den Pfeiltasten bewegen; das Mausrad vergrößert. Z oder Esc schließt sie</translation>
  </message>
  <message>
   <source>file names</source>
   <translation>Dateinamen</translation>
  </message>
  <message>
   <source>mirror sphere</source>
   <translation>Spiegelkugel</translation>
  </message>
  <message>
   <source>light positions</source>
   <translation>Lichtpositionen</translation>
  </message>
  <message>
   <source>calibrated lights</source>
   <translation>kalibrierte Lichter</translation>
  </message>
  <message>
   <source>estimated from the photographs</source>
   <translation>aus den Fotos geschätzt</translation>
  </message>
  <message>
   <source>Capture</source>
   <translation>Aufnahme</translation>
  </message>
  <message>
   <source>Extent</source>
   <translation>Umfang</translation>
  </message>
  <message>
   <source>Angles</source>
   <translation>Winkel</translation>
  </message>
  <message>
   <source>Source of the light's elevations</source>
   <translation>Herkunft der Elevationen des Lichts</translation>
  </message>
  <message>
   <source>Import</source>
   <translation>Import</translation>
  </message>
  <message>
   <source>Import again</source>
   <translation>Neu importieren</translation>
  </message>
  <message>
   <source>Report</source>
   <translation>Befunde</translation>
  </message>
  <message>
   <source>Build material</source>
   <translation>Material erzeugen</translation>
  </message>
  <message>
   <source>not recorded</source>
   <translation>nicht vermerkt</translation>
  </message>
  <message>
   <source>No angles were found, so even steps are assumed. Double-click an angle to correct it: elevation / azimuth.</source>
   <translation>Keine Winkel gefunden; gleiche Schritte sind angenommen. Doppelklick auf einen Winkel korrigiert ihn: Elevation / Azimut.</translation>
  </message>
  <message>
   <source>Needs the photographs</source>
   <translation>Braucht die Fotos</translation>
  </message>
  <message>
   <source>Read the photographs with these settings (Ctrl+Enter)</source>
   <translation>Die Fotos mit diesen Einstellungen lesen (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>Linearise the photographs into slices and compress them (Ctrl+Enter)</source>
   <translation>Die Fotos in Schichten linearisieren und komprimieren (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>Rebuild material</source>
   <translation>Material neu erzeugen</translation>
  </message>
  <message>
   <source>There are no photographs to read again</source>
   <translation>Es gibt keine Fotos, die neu gelesen werden könnten</translation>
  </message>
  <message>
   <source>The photographs are being imported</source>
   <translation>Die Fotos werden importiert</translation>
  </message>
  <message>
   <source>Nothing was changed</source>
   <translation>Nichts wurde geändert</translation>
  </message>
  <message>
   <source>Waiting for the photographs</source>
   <translation>Wartet auf die Fotos</translation>
  </message>
  <message>
   <source>The material is being built</source>
   <translation>Das Material wird erzeugt</translation>
  </message>
  <message>
   <source>The material is up to date</source>
   <translation>Das Material ist aktuell</translation>
  </message>
  <message>
   <source>All</source>
   <translation>Alle</translation>
  </message>
  <message>
   <source>No photograph is used</source>
   <translation>Kein Foto wird verwendet</translation>
  </message>
  <message>
   <source>Excluded</source>
   <translation>Ausgeschlossen</translation>
  </message>
  <message>
   <source>No photograph is excluded</source>
   <translation>Kein Foto ist ausgeschlossen</translation>
  </message>
  <message>
   <source>With warnings</source>
   <translation>Mit Warnungen</translation>
  </message>
  <message>
   <source>No photograph has a warning</source>
   <translation>Kein Foto hat eine Warnung</translation>
  </message>
  <message>
   <source>Excluded from the material. </source>
   <translation>Vom Material ausgeschlossen. </translation>
  </message>
  <message>
   <source>
Double-click to enter elevation / azimuth in degrees (0 = right, 90 = up)</source>
   <translation>
Doppelklick: Elevation / Azimut in Grad eingeben (0 = rechts, 90 = oben)</translation>
  </message>
  <message>
   <source>%1, %2 degrees, %3</source>
   <translation>%1, %2 Grad, %3</translation>
  </message>
  <message>
   <source>Photographs</source>
   <translation>Fotos</translation>
  </message>
  <message>
   <source>Photographs that are shown</source>
   <translation>Angezeigte Fotos</translation>
  </message>
  <message>
   <source>Open other photographs…</source>
   <translation>Andere Fotos öffnen…</translation>
  </message>
  <message>
   <source>%1 of %2</source>
   <translation>%1 von %2</translation>
  </message>
  <message>
   <source>Elevation / azimuth of the light in degrees</source>
   <translation>Elevation / Azimut des Lichts in Grad</translation>
  </message>
  <message>
   <source>The stack was opened without its photographs</source>
   <translation>Der Stapel wurde ohne seine Fotos geöffnet</translation>
  </message>
  <message>
   <source>Dark frame</source>
   <translation>Dunkelbild</translation>
  </message>
  <message>
   <source>Flat field</source>
   <translation>Weißbild</translation>
  </message>
  <message>
   <source> %1 photographs</source>
   <translation> %1 Fotos</translation>
  </message>
  <message>
   <source>Use%1</source>
   <translation>Verwenden%1</translation>
  </message>
  <message>
   <source>Exclude%1</source>
   <translation>Ausschließen%1</translation>
  </message>
  <message>
   <source>Select two photographs or more</source>
   <translation>Zwei oder mehr Fotos auswählen</translation>
  </message>
  <message>
   <source>Select one photograph</source>
   <translation>Ein Foto auswählen</translation>
  </message>
  <message>
   <source>Set as</source>
   <translation>Verwenden als</translation>
  </message>
  <message>
   <source>All are aligned to it already</source>
   <translation>Alle sind schon darauf ausgerichtet</translation>
  </message>
  <message>
   <source>Align to %1</source>
   <translation>Auf %1 ausrichten</translation>
  </message>
  <message>
   <source>Reference of the alignment</source>
   <translation>Referenz der Ausrichtung</translation>
  </message>
  <message>
   <source>Replace file…</source>
   <translation>Datei ersetzen…</translation>
  </message>
  <message>
   <source>Show file</source>
   <translation>Datei zeigen</translation>
  </message>
  <message>
   <source>Select all	Ctrl+A</source>
   <translation>Alle auswählen	Strg+A</translation>
  </message>
  <message>
   <source>Invert selection</source>
   <translation>Auswahl umkehren</translation>
  </message>
  <message>
   <source>All are selected</source>
   <translation>Alle sind ausgewählt</translation>
  </message>
  <message>
   <source>Already %1</source>
   <translation>Bereits %1</translation>
  </message>
  <message>
   <source>A photograph in place of %1</source>
   <translation>Ein Foto statt %1</translation>
  </message>
  <message>
   <source>Replace %1</source>
   <translation>%1 ersetzen</translation>
  </message>
  <message>
   <source>looking at the photographs</source>
   <translation>Fotos werden untersucht</translation>
  </message>
  <message>
   <source>Point</source>
   <translation>Punkt</translation>
  </message>
  <message>
   <source>In the reference</source>
   <translation>In der Referenz</translation>
  </message>
  <message>
   <source>In the photograph</source>
   <translation>Im Foto</translation>
  </message>
  <message>
   <source>Misses by</source>
   <translation>Abweichung</translation>
  </message>
  <message>
   <source>a shift</source>
   <translation>eine Verschiebung</translation>
  </message>
  <message>
   <source>a shift and a turn</source>
   <translation>eine Verschiebung und Drehung</translation>
  </message>
  <message>
   <source>an affine motion</source>
   <translation>eine affine Bewegung</translation>
  </message>
  <message>
   <source>a perspective motion</source>
   <translation>eine perspektivische Bewegung</translation>
  </message>
  <message>
   <source>Reference photograph</source>
   <translation>Referenzfoto</translation>
  </message>
  <message>
   <source>The photograph that the others are aligned to; points of another reference go</source>
   <translation>Das Foto, auf das die anderen ausgerichtet werden; Punkte einer anderen Referenz entfallen</translation>
  </message>
  <message>
   <source>Points in the reference</source>
   <translation>Punkte in der Referenz</translation>
  </message>
  <message>
   <source>Points in the photograph</source>
   <translation>Punkte im Foto</translation>
  </message>
  <message>
   <source>Control points</source>
   <translation>Passpunkte</translation>
  </message>
  <message>
   <source>Add a point</source>
   <translation>Punkt hinzufügen</translation>
  </message>
  <message>
   <source>In the middle of both images, to be moved from there (Ins)</source>
   <translation>In der Mitte beider Bilder, zum Verschieben von dort (Einfg)</translation>
  </message>
  <message>
   <source>Delete</source>
   <translation>Löschen</translation>
  </message>
  <message>
   <source>The chosen point (Del)</source>
   <translation>Den gewählten Punkt (Entf)</translation>
  </message>
  <message>
   <source>Remove all</source>
   <translation>Alle entfernen</translation>
  </message>
  <message>
   <source>The points of all photographs</source>
   <translation>Die Punkte aller Fotos</translation>
  </message>
  <message>
   <source>Done</source>
   <translation>Fertig</translation>
  </message>
  <message>
   <source>Back to the images (Esc)</source>
   <translation>Zurück zu den Bildern (Esc)</translation>
  </message>
  <message>
   <source>Reference</source>
   <translation>Referenz</translation>
  </message>
  <message>
   <source>%1 is the reference. Choose the photograph that is to be moved in the list.</source>
   <translation>%1 ist die Referenz. Das zu verschiebende Foto in der Liste wählen.</translation>
  </message>
  <message>
   <source>%1 px</source>
   <translation>%1 px</translation>
  </message>
  <message>
   <source>%1 / %2 px</source>
   <translation>%1 / %2 px</translation>
  </message>
  <message>
   <source>There are no points</source>
   <translation>Es gibt keine Punkte</translation>
  </message>
  <message>
   <source>This is the reference itself</source>
   <translation>Das ist die Referenz selbst</translation>
  </message>
  <message>
   <source>In the middle of both images (Ins)</source>
   <translation>In der Mitte beider Bilder (Einfg)</translation>
  </message>
  <message>
   <source>No point is chosen</source>
   <translation>Kein Punkt ist gewählt</translation>
  </message>
  <message>
   <source>Reading the photograph</source>
   <translation>Foto wird gelesen</translation>
  </message>
  <message>
   <source>Mark a point</source>
   <translation>Punkt setzen</translation>
  </message>
  <message>
   <source>Move a point</source>
   <translation>Punkt verschieben</translation>
  </message>
  <message>
   <source>Delete a point</source>
   <translation>Punkt löschen</translation>
  </message>
  <message>
   <source>Remove all points</source>
   <translation>Alle Punkte entfernen</translation>
  </message>
  <message>
   <source>Now click the same spot in %1. Esc forgets it.</source>
   <translation>Jetzt dieselbe Stelle in %1 anklicken. Esc bricht ab.</translation>
  </message>
  <message>
   <source>Points are marked in a photograph and in the reference that it is moved to.</source>
   <translation>Punkte werden in einem Foto und in der Referenz gesetzt, auf die es verschoben wird.</translation>
  </message>
  <message>
   <source>One point gives</source>
   <translation>Ein Punkt ergibt</translation>
  </message>
  <message>
   <source>%1 points give</source>
   <translation>%1 Punkte ergeben</translation>
  </message>
  <message>
   <source>Click a spot in one image, then the same spot in the other. %1 %2; more of them</source>
   <translation>Eine Stelle in einem Bild anklicken, dann dieselbe im anderen. %1 %2; mehr davon</translation>
  </message>
  <message>
   <source>%1 average out what each misses.</source>
   <translation>%1 mitteln die Abweichungen der einzelnen Punkte.</translation>
  </message>
  <message>
   <source>%1 of the %2 points that %3 needs: so far %4.</source>
   <translation>%1 von %2 Punkten, die %3 braucht: bisher %4.</translation>
  </message>
  <message>
   <source>These points do not determine %1: they lie on one line, too close together, or swapped.</source>
   <translation>Diese Punkte bestimmen %1 nicht: sie liegen auf einer Geraden, zu eng beieinander oder sind vertauscht.</translation>
  </message>
  <message>
   <source>%1 %2 is used.</source>
   <translation>%1 %2 wird verwendet.</translation>
  </message>
  <message>
   <source>Imported</source>
   <translation>Importiert</translation>
  </message>
  <message>
   <source>For the next import</source>
   <translation>Für den nächsten Import</translation>
  </message>
  <message>
   <source>%1: %2 from %3 points, so nothing shows what they miss; add one.</source>
   <translation>%1: %2 aus %3 Punkten; ihre Abweichung zeigt erst ein weiterer Punkt.</translation>
  </message>
  <message>
   <source>%1: %2 from %3 points, which misses them by %4 px.</source>
   <translation>%1: %2 aus %3 Punkten, Abweichung %4 px.</translation>
  </message>
  <message>
   <source>Photograph</source>
   <translation>Foto</translation>
  </message>
  <message>
   <source>Reflection</source>
   <translation>Spiegelbild</translation>
  </message>
  <message>
   <source>Source</source>
   <translation>Quelle</translation>
  </message>
  <message>
   <source>Column</source>
   <translation>Spalte</translation>
  </message>
  <message>
   <source>Row</source>
   <translation>Zeile</translation>
  </message>
  <message>
   <source>Looking at the sphere</source>
   <translation>Kugel wird untersucht</translation>
  </message>
  <message>
   <source>Lights on the sphere</source>
   <translation>Lichter auf der Kugel</translation>
  </message>
  <message>
   <source>Radius</source>
   <translation>Radius</translation>
  </message>
  <message>
   <source>%1 of the sphere</source>
   <translation>%1 der Kugel</translation>
  </message>
  <message>
   <source>Find again</source>
   <translation>Neu suchen</translation>
  </message>
  <message>
   <source>Undo all moves by hand</source>
   <translation>Alle Verschiebungen von Hand zurücknehmen</translation>
  </message>
  <message>
   <source>Nothing was moved by hand</source>
   <translation>Nichts wurde von Hand verschoben</translation>
  </message>
  <message>
   <source>The photographs are being looked at</source>
   <translation>Die Fotos werden untersucht</translation>
  </message>
  <message>
   <source>by hand</source>
   <translation>von Hand</translation>
  </message>
  <message>
   <source>not found</source>
   <translation>nicht gefunden</translation>
  </message>
  <message>
   <source>Looking for the sphere in the photographs…</source>
   <translation>Die Kugel wird in den Fotos gesucht…</translation>
  </message>
  <message>
   <source>No sphere was found by itself: drag the circle and its rim onto it.</source>
   <translation>Keine Kugel gefunden: den Kreis und seinen Rand darauf ziehen.</translation>
  </message>
  <message>
   <source>No light from %1%2: click the lamp's reflection inside the circle.</source>
   <translation>Kein Licht aus %1%2: das Spiegelbild der Lampe im Kreis anklicken.</translation>
  </message>
  <message>
   <source>Drag the circle and its rim onto the sphere, and the marker onto the lamp in each image.</source>
   <translation>Den Kreis und seinen Rand auf die Kugel ziehen und in jedem Bild die Marke auf die Lampe.</translation>
  </message>
  <message>
   <source>Move the sphere</source>
   <translation>Kugel verschieben</translation>
  </message>
  <message>
   <source>Move the reflection</source>
   <translation>Spiegelbild verschieben</translation>
  </message>
  <message>
   <source>Find the sphere again</source>
   <translation>Kugel neu suchen</translation>
  </message>
  <message>
   <source>looking at the sphere</source>
   <translation>Kugel wird untersucht</translation>
  </message>
  <message>
   <source>looking for the lamp's reflection</source>
   <translation>Spiegelbild der Lampe wird gesucht</translation>
  </message>
  <message>
   <source>Mirror sphere</source>
   <translation>Spiegelkugel</translation>
  </message>
  <message>
   <source>Lights with intensities (*.lights);;Directions alone (*.lp)</source>
   <translation>Lichter mit Intensitäten (*.lights);;Nur Richtungen (*.lp)</translation>
  </message>
  <message>
   <source>These photographs are not imported. Import again reads them.</source>
   <translation>Diese Fotos sind nicht importiert. „Neu importieren“ liest sie.</translation>
  </message>
  <message>
   <source>Grey patch</source>
   <translation>Graufeld</translation>
  </message>
  <message>
   <source>Previous photograph</source>
   <translation>Vorheriges Foto</translation>
  </message>
  <message>
   <source>Left</source>
   <translation>Links</translation>
  </message>
  <message>
   <source>Next photograph</source>
   <translation>Nächstes Foto</translation>
  </message>
  <message>
   <source>Right</source>
   <translation>Rechts</translation>
  </message>
  <message>
   <source>Fit image</source>
   <translation>Bild einpassen</translation>
  </message>
  <message>
   <source>Mark clipped texels</source>
   <translation>Übersteuerte Texel markieren</translation>
  </message>
  <message>
   <source>Exclude photograph</source>
   <translation>Foto ausschließen</translation>
  </message>
  <message>
   <source>Drop photographs here, or try the sample capture</source>
   <translation>Fotos hierher ziehen oder die Beispielaufnahme öffnen</translation>
  </message>
  <message>
   <source>About ten photographs of a flat sample under a lamp that moves along an arc: RAW, TIFF, PNG, JPEG, EXR or HDR. Angles are read from capture.toml, an .lp file or the file names.</source>
   <translation>Etwa zehn Fotos einer flachen Probe unter einer Lampe, die auf einem Bogen bewegt wird: RAW, TIFF, PNG, JPEG, EXR oder HDR. Winkel werden aus capture.toml, einer .lp-Datei oder den Dateinamen gelesen.</translation>
  </message>
  <message>
   <source>Choose photographs…</source>
   <translation>Fotos wählen…</translation>
  </message>
  <message>
   <source>Try the sample capture</source>
   <translation>Beispielaufnahme öffnen</translation>
  </message>
  <message>
   <source>Save the lights</source>
   <translation>Lichter speichern</translation>
  </message>
  <message>
   <source>Saving %1</source>
   <translation>%1 wird gespeichert</translation>
  </message>
  <message>
   <source>Preparing the image</source>
   <translation>Bild wird vorbereitet</translation>
  </message>
  <message>
   <source>Reading thumbnails</source>
   <translation>Vorschaubilder werden gelesen</translation>
  </message>
  <message>
   <source>Exclude %1 photographs</source>
   <translation>%1 Fotos ausschließen</translation>
  </message>
  <message>
   <source>Whole image</source>
   <translation>Ganzes Bild</translation>
  </message>
  <message>
   <source>Looking at the photograph</source>
   <translation>Foto wird untersucht</translation>
  </message>
  <message>
   <source>Frame the image</source>
   <translation>Bildausschnitt wählen</translation>
  </message>
  <message>
   <source>Angle of %1</source>
   <translation>Winkel von %1</translation>
  </message>
  <message>
   <source>saving the lights</source>
   <translation>Lichter werden gespeichert</translation>
  </message>
  <message>
   <source>Saved %1 lights as %2</source>
   <translation>%1 Lichter als %2 gespeichert</translation>
  </message>
 </context>
 <context>
  <name>material</name>
  <message>
   <source>Held out</source>
   <translation>Validierung</translation>
  </message>
  <message>
   <source>Root mean square error of photographs held out in turn</source>
   <translation>Quadratischer Mittelwert des Fehlers nacheinander zurückgehaltener Fotos</translation>
  </message>
  <message>
   <source>Training</source>
   <translation>Training</translation>
  </message>
  <message>
   <source>The same of the photographs that the map was made of, which flatters it</source>
   <translation>Derselbe Fehler für die Fotos, aus denen die Karte entstand; er ist zu günstig</translation>
  </message>
  <message>
   <source>Bytes</source>
   <translation>Bytes</translation>
  </message>
  <message>
   <source>Of a texel, before compression</source>
   <translation>Je Texel, vor der Kompression</translation>
  </message>
  <message>
   <source>Directional map</source>
   <translation>Richtungskarte</translation>
  </message>
  <message>
   <source>Shading map</source>
   <translation>Schattierungskarte</translation>
  </message>
  <message>
   <source>Mean image</source>
   <translation>Mittleres Bild</translation>
  </message>
  <message>
   <source>Worse than the mean image: %1s do not suit these photographs.</source>
   <translation>Schlechter als das mittlere Bild: %1 passt nicht zu diesen Fotos.</translation>
  </message>
  <message>
   <source>Held-out error equals that of the mean image.</source>
   <translation>Der Validierungsfehler gleicht dem des mittleren Bildes.</translation>
  </message>
  <message>
   <source>Held-out error is %1x lower than the mean image.</source>
   <translation>Der Validierungsfehler ist %1-mal kleiner als der des mittleren Bildes.</translation>
  </message>
  <message>
   <source>Error (8-bit levels)</source>
   <translation>Fehler (8-Bit-Stufen)</translation>
  </message>
  <message>
   <source>Direction of the light</source>
   <translation>Richtung des Lichts</translation>
  </message>
  <message>
   <source>Drag the light, or move it with the arrow keys</source>
   <translation>Das Licht ziehen oder mit den Pfeiltasten bewegen</translation>
  </message>
  <message>
   <source>The light of pairs under polarisers that the material is made of</source>
   <translation>Das Licht der Paare unter Polfiltern, aus dem das Material besteht</translation>
  </message>
  <message>
   <source>Automatic</source>
   <translation>Automatisch</translation>
  </message>
  <message>
   <source>Diffuse</source>
   <translation>Diffus</translation>
  </message>
  <message>
   <source>Without highlights, which the BRDF adds</source>
   <translation>Ohne Glanzlichter, die die BRDF hinzufügt</translation>
  </message>
  <message>
   <source>Whole</source>
   <translation>Ganz</translation>
  </message>
  <message>
   <source>With the highlights of the photographs</source>
   <translation>Mit den Glanzlichtern der Fotos</translation>
  </message>
  <message>
   <source>Representation</source>
   <translation>Darstellung</translation>
  </message>
  <message>
   <source>Relighting the material</source>
   <translation>Material wird neu beleuchtet</translation>
  </message>
  <message>
   <source>Light</source>
   <translation>Licht</translation>
  </message>
  <message>
   <source>Direction</source>
   <translation>Richtung</translation>
  </message>
  <message>
   <source>Elevation and azimuth of the light; dots are the lamps of the capture</source>
   <translation>Elevation und Azimut des Lichts; Punkte sind die Lampen der Aufnahme</translation>
  </message>
  <message>
   <source>Exposure</source>
   <translation>Belichtung</translation>
  </message>
  <message>
   <source>Brightness of this image alone; the material stays as it is</source>
   <translation>Helligkeit nur dieses Bildes; das Material bleibt, wie es ist</translation>
  </message>
  <message>
   <source>Kind</source>
   <translation>Art</translation>
  </message>
  <message>
   <source>Automatic: the one with the smaller error of held-out photographs</source>
   <translation>Automatisch: die mit dem kleineren Fehler zurückgehaltener Fotos</translation>
  </message>
  <message>
   <source>Pairs</source>
   <translation>Paare</translation>
  </message>
  <message>
   <source>Planes</source>
   <translation>Ebenen</translation>
  </message>
  <message>
   <source>Images in 8 bits, whose weighted sum is the image under a light</source>
   <translation>Bilder in 8 Bit, deren gewichtete Summe das Bild unter einem Licht ist</translation>
  </message>
  <message>
   <source>%1, %2 a texel</source>
   <translation>%1, %2 je Texel</translation>
  </message>
  <message>
   <source>Elevation %1°, azimuth %2°</source>
   <translation>Elevation %1°, Azimut %2°</translation>
  </message>
  <message>
   <source>relighting the material</source>
   <translation>Material wird neu beleuchtet</translation>
  </message>
  <message>
   <source>Base colour</source>
   <translation>Grundfarbe</translation>
  </message>
  <message>
   <source>Normals</source>
   <translation>Normalen</translation>
  </message>
  <message>
   <source>Roughness</source>
   <translation>Rauheit</translation>
  </message>
  <message>
   <source>Metallic</source>
   <translation>Metallisch</translation>
  </message>
  <message>
   <source>Specular (f0)</source>
   <translation>Spiegelnd (F0)</translation>
  </message>
  <message>
   <source>Height</source>
   <translation>Höhe</translation>
  </message>
  <message>
   <source>Occlusion</source>
   <translation>Verdeckung</translation>
  </message>
  <message>
   <source>Preparing the map</source>
   <translation>Karte wird vorbereitet</translation>
  </message>
  <message>
   <source>PBR maps</source>
   <translation>PBR-Karten</translation>
  </message>
  <message>
   <source>Map</source>
   <translation>Karte</translation>
  </message>
  <message>
   <source>The map that is shown; numbers are shown as shades, normals as colours</source>
   <translation>Die gezeigte Karte; Zahlen als Graustufen, Normalen als Farben</translation>
  </message>
  <message>
   <source>Mean</source>
   <translation>Mittel</translation>
  </message>
  <message>
   <source>Over all texels; bakes are of the BRDF at the mean of all maps</source>
   <translation>Über alle Texel; vorberechnet wird die BRDF beim Mittel aller Karten</translation>
  </message>
  <message>
   <source>Every mode but Direct draws each texel. Bakes are of one BRDF, at the mean of the maps.</source>
   <translation>Alle Modi außer „Direkt“ zeichnen jeden Texel. Vorberechnet wird eine einzige BRDF, beim Mittel der Karten.</translation>
  </message>
  <message>
   <source>preparing the map</source>
   <translation>Karte wird vorbereitet</translation>
  </message>
  <message>
   <source>Directions of the surface: red to the right, green up, blue out of the image</source>
   <translation>Richtungen der Oberfläche: rot nach rechts, grün nach oben, blau aus dem Bild heraus</translation>
  </message>
  <message>
   <source>Height of the surface in texels, from its lowest to its highest</source>
   <translation>Höhe der Oberfläche in Texeln, von der tiefsten zur höchsten Stelle</translation>
  </message>
  <message>
   <source>Colour of the surface without light: of diffuse reflection, or of metal</source>
   <translation>Farbe der Oberfläche ohne Licht: der diffusen Reflexion oder des Metalls</translation>
  </message>
  <message>
   <source>Roughness of the surface: 0 reflects like a mirror, 1 has the broadest highlights</source>
   <translation>Rauheit der Oberfläche: 0 spiegelt, 1 hat die breitesten Glanzlichter</translation>
  </message>
  <message>
   <source>Specular</source>
   <translation>Spiegelnd</translation>
  </message>
  <message>
   <source>F0 of a non-metal, its reflectance at normal incidence; plastic has 0.04</source>
   <translation>F0 eines Nichtmetalls, sein Reflexionsgrad bei senkrechtem Einfall; Kunststoff hat 0,04</translation>
  </message>
  <message>
   <source>1 where highlights have the colour of metal</source>
   <translation>1, wo Glanzlichter die Farbe von Metall haben</translation>
  </message>
  <message>
   <source>Sky visibility</source>
   <translation>Himmelsanteil</translation>
  </message>
  <message>
   <source>Share of the light of an even sky that relief leaves</source>
   <translation>Anteil des Lichts eines gleichmäßigen Himmels, den das Relief durchlässt</translation>
  </message>
  <message>
   <source> of full white</source>
   <translation> von vollem Weiß</translation>
  </message>
  <message>
   <source>The %1 is unknown at most texels.</source>
   <translation>%1: an den meisten Texeln unbekannt.</translation>
  </message>
  <message>
   <source>95 % below %1%2</source>
   <translation>95 % unter %1%2</translation>
  </message>
  <message>
   <source>unknown at more than 5 % of the texels</source>
   <translation>an mehr als 5 % der Texel unbekannt</translation>
  </message>
  <message>
   <source>Median %1 uncertainty %2%3 (1 sigma), %4.</source>
   <translation>Mittlere Unsicherheit (%1): %2%3 (1 Sigma), %4.</translation>
  </message>
  <message>
   <source>Each of %1 regions counts from its own mean: the steps between them, along the lines, are unknown.</source>
   <translation>Jeder von %1 Bereichen zählt von seinem eigenen Mittel: die Stufen dazwischen, an den Linien, sind unbekannt.</translation>
  </message>
  <message>
   <source>tilted by %1° (median)</source>
   <translation>um %1° geneigt (Median)</translation>
  </message>
  <message>
   <source>%1 on average</source>
   <translation>%1 im Mittel</translation>
  </message>
  <message>
   <source>%1 to %2</source>
   <translation>%1 bis %2</translation>
  </message>
  <message>
   <source>Material</source>
   <translation>Material</translation>
  </message>
  <message>
   <source>The material as it is drawn under light</source>
   <translation>Das Material, wie es unter Licht gezeichnet wird</translation>
  </message>
  <message>
   <source>Surface maps</source>
   <translation>Oberfläche</translation>
  </message>
  <message>
   <source>Normals, height, base colour, roughness and specular, found from the photographs</source>
   <translation>Normalen, Höhe, Grundfarbe, Rauheit und Spiegelung, aus den Fotos bestimmt</translation>
  </message>
  <message>
   <source>The map itself</source>
   <translation>Die Karte selbst</translation>
  </message>
  <message>
   <source>Uncertainty</source>
   <translation>Unsicherheit</translation>
  </message>
  <message>
   <source>One standard deviation of the map in each texel</source>
   <translation>Eine Standardabweichung der Karte an jedem Texel</translation>
  </message>
  <message>
   <source>Found</source>
   <translation>Ermittelt</translation>
  </message>
  <message>
   <source>The white level of the photographs, or more where texels are brighter</source>
   <translation>Der Weißpegel der Fotos oder mehr, wo Texel heller sind</translation>
  </message>
  <message>
   <source>Measured</source>
   <translation>Gemessen</translation>
  </message>
  <message>
   <source>The radiance of a white reference that faces a lamp, as you measured it in a photograph</source>
   <translation>Die Strahldichte einer weißen Referenz, die einer Lampe zugewandt ist, in einem Foto gemessen</translation>
  </message>
  <message>
   <source>along the arc</source>
   <translation>längs des Bogens</translation>
  </message>
  <message>
   <source>both directions</source>
   <translation>beide Richtungen</translation>
  </message>
  <message>
   <source>Colour</source>
   <translation>Farbe</translation>
  </message>
  <message>
   <source>Sky</source>
   <translation>Himmel</translation>
  </message>
  <message>
   <source>No surface maps yet</source>
   <translation>Noch keine Oberflächenkarten</translation>
  </message>
  <message>
   <source>Photographs under lamps on several sides give the normals, the height and the reflectance of the surface, each map with its uncertainty. Make surface maps, on the right.</source>
   <translation>Fotos unter Lampen auf mehreren Seiten ergeben Normalen, Höhe und Reflexion der Oberfläche, jede Karte mit ihrer Unsicherheit. Rechts „Oberflächenkarten erzeugen“ wählen.</translation>
  </message>
  <message>
   <source>Show</source>
   <translation>Anzeigen</translation>
  </message>
  <message>
   <source>Values</source>
   <translation>Werte</translation>
  </message>
  <message>
   <source>Those of all but two in a thousand texels</source>
   <translation>Die aller Texel bis auf zwei von tausend</translation>
  </message>
  <message>
   <source>Surface</source>
   <translation>Oberfläche</translation>
  </message>
  <message>
   <source>Slopes</source>
   <translation>Steigungen</translation>
  </message>
  <message>
   <source>The slopes that the lamps of the capture determine</source>
   <translation>Die Steigungen, die die Lampen der Aufnahme bestimmen</translation>
  </message>
  <message>
   <source>White</source>
   <translation>Weiß</translation>
  </message>
  <message>
   <source>The white reference, of which reflectance is a share</source>
   <translation>Die weiße Referenz, deren Anteil der Reflexionsgrad ist</translation>
  </message>
  <message>
   <source>Radiance</source>
   <translation>Strahldichte</translation>
  </message>
  <message>
   <source>Of photographs as the maps show them</source>
   <translation>Der Fotos, wie die Karten sie zeigen</translation>
  </message>
  <message>
   <source>Photographs that the maps were made without, each in turn</source>
   <translation>Nacheinander zurückgehaltene Fotos</translation>
  </message>
  <message>
   <source>Photographs that the maps were made of</source>
   <translation>Fotos, aus denen die Karten entstanden</translation>
  </message>
  <message>
   <source>The mean of the other photographs in place of each</source>
   <translation>Statt jedes Fotos das Mittel der anderen</translation>
  </message>
  <message>
   <source>Follows the maps.</source>
   <translation>Erscheint mit den Karten.</translation>
  </message>
  <message>
   <source>Save maps…</source>
   <translation>Karten speichern…</translation>
  </message>
  <message>
   <source>Make surface maps</source>
   <translation>Oberflächenkarten erzeugen</translation>
  </message>
  <message>
   <source>%1 maps</source>
   <translation>Karten von %1</translation>
  </message>
  <message>
   <source>Save maps in a new folder</source>
   <translation>Karten in einem neuen Ordner speichern</translation>
  </message>
  <message>
   <source>Needs the photographs of the capture</source>
   <translation>Braucht die Fotos der Aufnahme</translation>
  </message>
  <message>
   <source>The maps are being made</source>
   <translation>Die Karten werden erzeugt</translation>
  </message>
  <message>
   <source>The maps are up to date</source>
   <translation>Die Karten sind aktuell</translation>
  </message>
  <message>
   <source>Find the surface behind the photographs that are in use (Ctrl+Enter)</source>
   <translation>Die Oberfläche hinter den verwendeten Fotos bestimmen (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>The white reference is estimated from the photographs</source>
   <translation>Die weiße Referenz wird aus den Fotos geschätzt</translation>
  </message>
  <message>
   <source>1 is the white level of the photographs; colours are shares of it</source>
   <translation>1 ist der Weißpegel der Fotos; Farben sind Anteile davon</translation>
  </message>
  <message>
   <source>Make them again</source>
   <translation>Neu erzeugen</translation>
  </message>
  <message>
   <source>There are no maps yet</source>
   <translation>Es gibt noch keine Karten</translation>
  </message>
  <message>
   <source>As EXR and PNG, with errors</source>
   <translation>Als EXR und PNG, mit Fehlern</translation>
  </message>
  <message>
   <source>The lamps stand on one arc: only the slope along %1° is observed, so there is no height.</source>
   <translation>Die Lampen stehen auf einem Bogen: nur die Steigung längs %1° ist sichtbar, deshalb gibt es keine Höhe.</translation>
  </message>
  <message>
   <source>This takes no less room than the slices alone. Raise the error bound, or use the power law for all texels.</source>
   <translation>Das braucht nicht weniger Platz als die Schichten allein. Die Fehlergrenze erhöhen oder das Potenzgesetz für alle Texel verwenden.</translation>
  </message>
  <message>
   <source>32 bits</source>
   <translation>32 Bit</translation>
  </message>
  <message>
   <source>16 bits</source>
   <translation>16 Bit</translation>
  </message>
  <message>
   <source>8 bits</source>
   <translation>8 Bit</translation>
  </message>
  <message>
   <source>Slices</source>
   <translation>Schichten</translation>
  </message>
  <message>
   <source>The shading map at the chosen r, interpolated between two slices</source>
   <translation>Die Schattierungskarte beim gewählten r, zwischen zwei Schichten interpoliert</translation>
  </message>
  <message>
   <source>Power law</source>
   <translation>Potenzgesetz</translation>
  </message>
  <message>
   <source>The compressed pair at the chosen r</source>
   <translation>Das komprimierte Paar beim gewählten r</translation>
  </message>
  <message>
   <source>Error</source>
   <translation>Fehler</translation>
  </message>
  <message>
   <source>Root mean square difference of the two over all slices, per texel</source>
   <translation>Quadratischer Mittelwert der Differenz beider über alle Schichten, je Texel</translation>
  </message>
  <message>
   <source>The material, repeated</source>
   <translation>Das Material, wiederholt</translation>
  </message>
  <message>
   <source>Finding the worst texels</source>
   <translation>Schlechteste Texel werden gesucht</translation>
  </message>
  <message>
   <source>Light of pairs</source>
   <translation>Licht der Paare</translation>
  </message>
  <message>
   <source>No material yet</source>
   <translation>Noch kein Material</translation>
  </message>
  <message>
   <source>Photographs become slices whose mean radiance grows evenly, and a power law compresses them to six numbers per texel. Import photographs first, or drop a .lightarc bundle, a folder of PBR textures or a MaterialX document.</source>
   <translation>Fotos werden zu Schichten, deren mittlere Strahldichte gleichmäßig wächst, und ein Potenzgesetz komprimiert sie auf sechs Zahlen je Texel. Zuerst Fotos importieren oder ein .lightarc-Paket, einen Ordner mit PBR-Texturen oder ein MaterialX-Dokument hierher ziehen.</translation>
  </message>
  <message>
   <source>Go to Capture</source>
   <translation>Zur Aufnahme</translation>
  </message>
  <message>
   <source>r, BRDF times cosine</source>
   <translation>r, BRDF mal Kosinus</translation>
  </message>
  <message>
   <source>Number of slices that the photographs are resampled to</source>
   <translation>Anzahl der Schichten, auf die die Fotos umgerechnet werden</translation>
  </message>
  <message>
   <source>Largest r</source>
   <translation>Größtes r</translation>
  </message>
  <message>
   <source>Mean luminance of the brightest photograph, a_max</source>
   <translation>Mittlere Leuchtdichte des hellsten Fotos, a_max</translation>
  </message>
  <message>
   <source>Evenness</source>
   <translation>Gleichmaß</translation>
  </message>
  <message>
   <source>Largest distance of a slice's mean from its target</source>
   <translation>Größte Abweichung des Mittels einer Schicht von ihrem Ziel</translation>
  </message>
  <message>
   <source>Compression</source>
   <translation>Kompression</translation>
  </message>
  <message>
   <source>Last slice</source>
   <translation>Letzte Schicht</translation>
  </message>
  <message>
   <source>Least squares</source>
   <translation>Kleinste Quadrate</translation>
  </message>
  <message>
   <source>Last slice: as in the paper, exact at the largest r. Least squares: never worse</source>
   <translation>Letzte Schicht: wie im Artikel, genau beim größten r. Kleinste Quadrate: nie schlechter</translation>
  </message>
  <message>
   <source>Bits of the exponent</source>
   <translation>Bits des Exponenten</translation>
  </message>
  <message>
   <source>Exponent</source>
   <translation>Exponent</translation>
  </message>
  <message>
   <source>Bits of a stored exponent; with 8 or 16 the scale takes 16 too</source>
   <translation>Bits eines gespeicherten Exponenten; mit 8 oder 16 hat auch der Maßstab 16</translation>
  </message>
  <message>
   <source>Rounding</source>
   <translation>Rundung</translation>
  </message>
  <message>
   <source>Largest change of a texel by fewer bits, in units of radiance</source>
   <translation>Größte Änderung eines Texels durch weniger Bits, in Strahldichte</translation>
  </message>
  <message>
   <source>Six numbers for every texel</source>
   <translation>Sechs Zahlen für jeden Texel</translation>
  </message>
  <message>
   <source>Mixed</source>
   <translation>Mix</translation>
  </message>
  <message>
   <source>Tiles in which a texel's error reaches the bound keep their slices</source>
   <translation>Kacheln, in denen der Fehler eines Texels die Grenze erreicht, behalten ihre Schichten</translation>
  </message>
  <message>
   <source>Mode</source>
   <translation>Modus</translation>
  </message>
  <message>
   <source>Error bound</source>
   <translation>Grenze</translation>
  </message>
  <message>
   <source>Kept tiles</source>
   <translation>Kacheln</translation>
  </message>
  <message>
   <source>Share of the tiles that keep their slices</source>
   <translation>Anteil der Kacheln, die ihre Schichten behalten</translation>
  </message>
  <message>
   <source>RMS error</source>
   <translation>RMS-Fehler</translation>
  </message>
  <message>
   <source>Over all texels, slices and channels, in units of radiance</source>
   <translation>Über alle Texel, Schichten und Kanäle, in Strahldichte</translation>
  </message>
  <message>
   <source>Of largest r</source>
   <translation>Vom max. r</translation>
  </message>
  <message>
   <source>Worst texel</source>
   <translation>Max. Fehler</translation>
  </message>
  <message>
   <source>Saved</source>
   <translation>Gespart</translation>
  </message>
  <message>
   <source>Texel</source>
   <translation>Texel</translation>
  </message>
  <message>
   <source>Worst texels</source>
   <translation>Schlechteste Texel</translation>
  </message>
  <message>
   <source>The bundle holds no slices</source>
   <translation>Das Paket enthält keine Schichten</translation>
  </message>
  <message>
   <source>The bundle holds no power law</source>
   <translation>Das Paket enthält kein Potenzgesetz</translation>
  </message>
  <message>
   <source>%1 slices</source>
   <translation>%1 Schichten</translation>
  </message>
  <message>
   <source>Scale from %1</source>
   <translation>Maßstab aus %1</translation>
  </message>
  <message>
   <source>Representation by itself</source>
   <translation>Darstellung automatisch</translation>
  </message>
  <message>
   <source>error bound</source>
   <translation>Fehlergrenze</translation>
  </message>
  <message>
   <source>The material came from a bundle; building again needs the photographs</source>
   <translation>Das Material stammt aus einem Paket; zum Neuerzeugen sind die Fotos nötig</translation>
  </message>
  <message>
   <source>Make the material again with these settings (Ctrl+Enter)</source>
   <translation>Das Material mit diesen Einstellungen neu erzeugen (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>Only the mixed mode has a bound</source>
   <translation>Nur der gemischte Modus hat eine Grenze</translation>
  </message>
  <message>
   <source>Of the largest r: tiles in which a texel's error reaches it keep their slices</source>
   <translation>Des größten r: Kacheln, in denen der Fehler eines Texels sie erreicht, behalten ihre Schichten</translation>
  </message>
  <message>
   <source>preparing the image</source>
   <translation>Bild wird vorbereitet</translation>
  </message>
  <message>
   <source>Show this texel</source>
   <translation>Diesen Texel zeigen</translation>
  </message>
  <message>
   <source>Texel in column %1, row %2</source>
   <translation>Texel in Spalte %1, Zeile %2</translation>
  </message>
  <message>
   <source>Place</source>
   <translation>Position</translation>
  </message>
  <message>
   <source>Column and row; click the image to choose another</source>
   <translation>Spalte und Zeile; Klick ins Bild wählt einen anderen</translation>
  </message>
  <message>
   <source>Residual</source>
   <translation>Residuum</translation>
  </message>
  <message>
   <source>Root mean square over slices and channels, in units of radiance</source>
   <translation>Quadratischer Mittelwert über Schichten und Kanäle, in Strahldichte</translation>
  </message>
  <message>
   <source>Scale k</source>
   <translation>Maßstab k</translation>
  </message>
  <message>
   <source>Red, green and blue</source>
   <translation>Rot, Grün und Blau</translation>
  </message>
  <message>
   <source>Exponent K</source>
   <translation>Exponent K</translation>
  </message>
  <message>
   <source>0, slices kept</source>
   <translation>0, Schichten behalten</translation>
  </message>
  <message>
   <source>finding the worst texels</source>
   <translation>schlechteste Texel werden gesucht</translation>
  </message>
  <message>
   <source>As cut</source>
   <translation>Original</translation>
  </message>
  <message>
   <source>The whole sample; its edges do not match</source>
   <translation>Die ganze Probe; ihre Ränder passen nicht zusammen</translation>
  </message>
  <message>
   <source>Tileable</source>
   <translation>Kachelbar</translation>
  </message>
  <message>
   <source>Cut along a path that is hard to see, so that opposite edges match</source>
   <translation>Entlang eines unauffälligen Pfads geschnitten, sodass gegenüberliegende Ränder passen</translation>
  </message>
  <message>
   <source>Edges</source>
   <translation>Ränder</translation>
  </message>
  <message>
   <source>Evened</source>
   <translation>Ausgegl.</translation>
  </message>
  <message>
   <source>Its slow change over the sample is divided out, which repeated makes bands</source>
   <translation>Die langsame Änderung über die Probe wird herausgerechnet, die beim Wiederholen Streifen ergibt</translation>
  </message>
  <message>
   <source>as it is</source>
   <translation>Original</translation>
  </message>
  <message>
   <source>As it is</source>
   <translation>Original</translation>
  </message>
  <message>
   <source>As in the photographs</source>
   <translation>Wie in den Fotos</translation>
  </message>
  <message>
   <source>Brightness</source>
   <translation>Helligkeit</translation>
  </message>
  <message>
   <source>Seams</source>
   <translation>Nähte</translation>
  </message>
  <message>
   <source>Steps across the seams of a tile relative to those inside the sample</source>
   <translation>Stufen an den Nähten einer Kachel im Verhältnis zu denen in der Probe</translation>
  </message>
  <message>
   <source>not tileable</source>
   <translation>nicht kachelbar</translation>
  </message>
  <message>
   <source>%1 × inside</source>
   <translation>%1 × innen</translation>
  </message>
  <message>
   <source>Only a tile is evened out</source>
   <translation>Nur eine Kachel wird ausgeglichen</translation>
  </message>
 </context>
 <context>
  <name>brdf</name>
  <message>
   <source>MERL (*.binary);;Table of Lightarc (*.exr)</source>
   <translation>MERL (*.binary);;Tabelle von Lightarc (*.exr)</translation>
  </message>
  <message>
   <source>%1;;All files (*)</source>
   <translation>%1;;Alle Dateien (*)</translation>
  </message>
  <message>
   <source>Measured BRDFs</source>
   <translation>Gemessene BRDFs</translation>
  </message>
  <message>
   <source>Open measured BRDFs</source>
   <translation>Gemessene BRDFs öffnen</translation>
  </message>
  <message>
   <source>Where is %1 now?</source>
   <translation>Wo ist %1 jetzt?</translation>
  </message>
  <message>
   <source>Save a table</source>
   <translation>Tabelle speichern</translation>
  </message>
  <message>
   <source>Save the plots to a folder</source>
   <translation>Diagramme in einen Ordner speichern</translation>
  </message>
  <message>
   <source>Copied %1</source>
   <translation>%1 kopiert</translation>
  </message>
  <message>
   <source>the text of %1</source>
   <translation>der Text von %1</translation>
  </message>
  <message>
   <source>Model</source>
   <translation>Modell</translation>
  </message>
  <message>
   <source>Log error</source>
   <translation>Log. Fehler</translation>
  </message>
  <message>
   <source>All models for %1</source>
   <translation>Alle Modelle für %1</translation>
  </message>
  <message>
   <source>Models by their error</source>
   <translation>Modelle nach ihrem Fehler</translation>
  </message>
  <message>
   <source>Error: RMS of BRDF × cosine relative to that of the data, which highlights outweigh. Log error: of the logarithms, where dim values count as much; the least is on top.</source>
   <translation>Fehler: RMS von BRDF × Kosinus im Verhältnis zu dem der Daten, wobei Glanzlichter überwiegen. Log. Fehler: der Logarithmen, wobei dunkle Werte ebenso zählen; der kleinste steht oben.</translation>
  </message>
  <message>
   <source>Add to the list</source>
   <translation>Zur Liste hinzufügen</translation>
  </message>
  <message>
   <source>Close</source>
   <translation>Schließen</translation>
  </message>
  <message>
   <source>taking samples</source>
   <translation>Abtastungen werden berechnet</translation>
  </message>
  <message>
   <source>Parts and light</source>
   <translation>Anteile und Licht</translation>
  </message>
  <message>
   <source>Relative errors, and for each colour as much light as the data reflect</source>
   <translation>Relative Fehler, und je Farbe so viel Licht, wie die Daten reflektieren</translation>
  </message>
  <message>
   <source>All parts</source>
   <translation>Alle Anteile</translation>
  </message>
  <message>
   <source>Relative errors: dim parts weigh as much as the highlight</source>
   <translation>Relative Fehler: dunkle Anteile wiegen so viel wie das Glanzlicht</translation>
  </message>
  <message>
   <source>Energy</source>
   <translation>Energie</translation>
  </message>
  <message>
   <source>Errors weighted by energy: a highlight outweighs all else</source>
   <translation>Nach Energie gewichtete Fehler: ein Glanzlicht überwiegt alles andere</translation>
  </message>
  <message>
   <source>Fit a model</source>
   <translation>Modell anpassen</translation>
  </message>
  <message>
   <source>The model to fit</source>
   <translation>Das anzupassende Modell</translation>
  </message>
  <message>
   <source>Counts</source>
   <translation>Zählt</translation>
  </message>
  <message>
   <source>Weight of each error in the fit</source>
   <translation>Gewicht jedes Fehlers in der Anpassung</translation>
  </message>
  <message>
   <source>Fit</source>
   <translation>Anpassen</translation>
  </message>
  <message>
   <source>Stop and keep</source>
   <translation>Beenden und behalten</translation>
  </message>
  <message>
   <source>The best parameters so far become an entry of the list</source>
   <translation>Die bisher besten Parameter werden ein Eintrag der Liste</translation>
  </message>
  <message>
   <source>Rank all models</source>
   <translation>Alle Modelle ordnen</translation>
  </message>
  <message>
   <source>Fit every model, and list them by their errors</source>
   <translation>Jedes Modell anpassen und nach den Fehlern auflisten</translation>
  </message>
  <message>
   <source>RMS of BRDF × cosine relative to that of the data: at the start → now</source>
   <translation>RMS von BRDF × Kosinus im Verhältnis zu dem der Daten: am Anfang → jetzt</translation>
  </message>
  <message>
   <source>Add a BRDF to the list first</source>
   <translation>Zuerst eine BRDF zur Liste hinzufügen</translation>
  </message>
  <message>
   <source>A fit is running</source>
   <translation>Eine Anpassung läuft</translation>
  </message>
  <message>
   <source>Find the parameters that bring the model nearest to %1</source>
   <translation>Die Parameter suchen, mit denen das Modell %1 am nächsten kommt</translation>
  </message>
  <message>
   <source>Fitting %1 to %2</source>
   <translation>%1 wird an %2 angepasst</translation>
  </message>
  <message>
   <source>Fitting all models to %1</source>
   <translation>Alle Modelle werden an %1 angepasst</translation>
  </message>
  <message>
   <source>Error %1 → %2</source>
   <translation>Fehler %1 → %2</translation>
  </message>
  <message>
   <source>Use for the material</source>
   <translation>Für das Material verwenden</translation>
  </message>
  <message>
   <source>Compared</source>
   <translation>Verglichen</translation>
  </message>
  <message>
   <source>Compared BRDFs</source>
   <translation>Verglichene BRDFs</translation>
  </message>
  <message>
   <source>Tick the entries to show (Space); Del removes one</source>
   <translation>Zu zeigende Einträge ankreuzen (Leertaste); Entf entfernt einen</translation>
  </message>
  <message>
   <source>Remove from the list</source>
   <translation>Von der Liste entfernen</translation>
  </message>
  <message>
   <source>Copy as text</source>
   <translation>Als Text kopieren</translation>
  </message>
  <message>
   <source>Save table…</source>
   <translation>Tabelle speichern…</translation>
  </message>
  <message>
   <source>Samples</source>
   <translation>Abtastungen</translation>
  </message>
  <message>
   <source>Measured directions, and the number of unusable ones</source>
   <translation>Gemessene Richtungen und die Anzahl der unbrauchbaren</translation>
  </message>
  <message>
   <source>Edit text…</source>
   <translation>Text bearbeiten…</translation>
  </message>
  <message>
   <source>Its GLSL in a window of its own; the views follow what is typed</source>
   <translation>Ihr GLSL in einem eigenen Fenster; die Ansichten folgen der Eingabe</translation>
  </message>
  <message>
   <source>Max. albedo</source>
   <translation>Max. Albedo</translation>
  </message>
  <message>
   <source>Largest reflected share of light in any channel, and its viewing angle</source>
   <translation>Größter reflektierter Lichtanteil eines Kanals und sein Blickwinkel</translation>
  </message>
  <message>
   <source>Reciprocity</source>
   <translation>Reziprozität</translation>
  </message>
  <message>
   <source>RMS change if light and viewer are exchanged, relative to the RMS of all values</source>
   <translation>RMS-Änderung beim Vertauschen von Licht und Blick, im Verhältnis zum RMS aller Werte</translation>
  </message>
  <message>
   <source>Condition</source>
   <translation>Kondition</translation>
  </message>
  <message>
   <source>Condition number of the smoothing of scattered samples</source>
   <translation>Konditionszahl der Glättung verstreuter Abtastungen</translation>
  </message>
  <message>
   <source>RMS error at samples held out of the fit, relative to the RMS</source>
   <translation>RMS-Fehler an zurückgehaltenen Abtastungen, im Verhältnis zum RMS</translation>
  </message>
  <message>
   <source>Fit error</source>
   <translation>Anpassung</translation>
  </message>
  <message>
   <source>Before and after the fit of this model</source>
   <translation>Vor und nach der Anpassung dieses Modells</translation>
  </message>
  <message>
   <source>Analytic model</source>
   <translation>Analytisches Modell</translation>
  </message>
  <message>
   <source>Remove it from the list (Del)</source>
   <translation>Von der Liste entfernen (Entf)</translation>
  </message>
  <message>
   <source>A measurement has no formula; fit a model first</source>
   <translation>Eine Messung hat keine Formel; zuerst ein Modell anpassen</translation>
  </message>
  <message>
   <source>Its text in GLSL</source>
   <translation>Ihr Text in GLSL</translation>
  </message>
  <message>
   <source>The text that names it on the command line</source>
   <translation>Der Text, der sie auf der Kommandozeile benennt</translation>
  </message>
  <message>
   <source>As a MERL .binary or as a Lightarc table (.exr)</source>
   <translation>Als MERL .binary oder als Lightarc-Tabelle (.exr)</translation>
  </message>
  <message>
   <source>Make it the BRDF of the View workspace and of the exported bundle</source>
   <translation>Zur BRDF des Arbeitsbereichs Ansicht und des exportierten Pakets machen</translation>
  </message>
  <message>
   <source>, %1 unusable</source>
   <translation>, %1 unbrauchbar</translation>
  </message>
  <message>
   <source>%1 at %2°</source>
   <translation>%1 bei %2°</translation>
  </message>
  <message>
   <source>holds within 0.01 %</source>
   <translation>gilt auf 0,01 %</translation>
  </message>
  <message>
   <source>off by %1</source>
   <translation>Abweichung %1</translation>
  </message>
  <message>
   <source>Search</source>
   <translation>Suche</translation>
  </message>
  <message>
   <source>Search the library</source>
   <translation>Bibliothek durchsuchen</translation>
  </message>
  <message>
   <source>Part of a name or of a model (Ctrl+F)</source>
   <translation>Teil eines Namens oder Modells (Strg+F)</translation>
  </message>
  <message>
   <source>Library of BRDFs</source>
   <translation>Bibliothek der BRDFs</translation>
  </message>
  <message>
   <source>Add</source>
   <translation>Hinzufügen</translation>
  </message>
  <message>
   <source>Add it to the compared BRDFs (Enter, or double-click)</source>
   <translation>Zu den verglichenen BRDFs hinzufügen (Eingabe oder Doppelklick)</translation>
  </message>
  <message>
   <source>Open file…</source>
   <translation>Öffnen…</translation>
  </message>
  <message>
   <source>MERL, RGL, UTIA, Cornell, ASTM, CUReT, ALTA, CSV, or a Lightarc table</source>
   <translation>MERL, RGL, UTIA, Cornell, ASTM, CUReT, ALTA, CSV oder eine Lightarc-Tabelle</translation>
  </message>
  <message>
   <source>Write one in GLSL</source>
   <translation>Selbst in GLSL schreiben</translation>
  </message>
  <message>
   <source>Begins as a small text that works; the views follow as you type</source>
   <translation>Beginnt als kurzer, lauffähiger Text; die Ansichten folgen der Eingabe</translation>
  </message>
  <message>
   <source>Begin with %1</source>
   <translation>Mit %1 beginnen</translation>
  </message>
  <message>
   <source>Files</source>
   <translation>Dateien</translation>
  </message>
  <message>
   <source>Models</source>
   <translation>Modelle</translation>
  </message>
  <message>
   <source>Published</source>
   <translation>Veröffentlicht</translation>
  </message>
  <message>
   <source>Find it…</source>
   <translation>Suchen…</translation>
  </message>
  <message>
   <source>Choose something in the library first</source>
   <translation>Zuerst etwas in der Bibliothek wählen</translation>
  </message>
  <message>
   <source>%1 (not found)</source>
   <translation>%1 (nicht gefunden)</translation>
  </message>
  <message>
   <source>Double-click to find the file</source>
   <translation>Doppelklick sucht die Datei</translation>
  </message>
  <message>
   <source>Measured BRDF</source>
   <translation>Gemessene BRDF</translation>
  </message>
  <message>
   <source>Drawing thumbnails</source>
   <translation>Vorschaubilder werden gezeichnet</translation>
  </message>
  <message>
   <source>looking for files</source>
   <translation>Dateien werden gesucht</translation>
  </message>
  <message>
   <source>Lobes in space</source>
   <translation>Keulen im Raum</translation>
  </message>
  <message>
   <source>Drag to rotate, wheel to zoom, Ctrl+drag to move the light, double-click to reset</source>
   <translation>Ziehen dreht, das Mausrad zoomt, Strg+Ziehen bewegt das Licht, Doppelklick setzt zurück</translation>
  </message>
  <message>
   <source>Values in the plane of incidence</source>
   <translation>Werte in der Einfallsebene</translation>
  </message>
  <message>
   <source>Distance from the centre: the value in that direction. Dashed line: the light</source>
   <translation>Abstand vom Mittelpunkt: der Wert in dieser Richtung. Gestrichelt: das Licht</translation>
  </message>
  <message>
   <source>θ half / °</source>
   <translation>θ Halb / °</translation>
  </message>
  <message>
   <source>θ difference / °</source>
   <translation>θ Differenz / °</translation>
  </message>
  <message>
   <source>Values over half and difference angle</source>
   <translation>Werte über Halb- und Differenzwinkel</translation>
  </message>
  <message>
   <source>The highlight is on the left, grazing reflection above, retro-reflection below</source>
   <translation>Das Glanzlicht ist links, streifende Reflexion oben, Rückstrahlung unten</translation>
  </message>
  <message>
   <source>%1–%2 sr⁻¹</source>
   <translation>%1–%2 sr⁻¹</translation>
  </message>
  <message>
   <source>Angle from the normal / °</source>
   <translation>Winkel zur Normalen / °</translation>
  </message>
  <message>
   <source>Albedo</source>
   <translation>Albedo</translation>
  </message>
  <message>
   <source>Albedo against angle</source>
   <translation>Albedo über dem Winkel</translation>
  </message>
  <message>
   <source>Above 1, the dashed line, the BRDF would reflect more light than it receives</source>
   <translation>Über 1, der gestrichelten Linie, würde die BRDF mehr Licht reflektieren, als sie erhält</translation>
  </message>
  <message>
   <source>Error / %</source>
   <translation>Fehler / %</translation>
  </message>
  <message>
   <source>Error of the fit by half angle</source>
   <translation>Fehler der Anpassung über dem Halbwinkel</translation>
  </message>
  <message>
   <source>RMS of BRDF × cosine relative to that of the data: the dashed line at the start of the fit</source>
   <translation>RMS von BRDF × Kosinus im Verhältnis zu dem der Daten: gestrichelt am Anfang der Anpassung</translation>
  </message>
  <message>
   <source>Sphere with this BRDF</source>
   <translation>Kugel mit dieser BRDF</translation>
  </message>
  <message>
   <source>Drag to rotate, Ctrl+drag or drag the sun to move the light</source>
   <translation>Ziehen dreht, Strg+Ziehen oder Ziehen der Sonne bewegt das Licht</translation>
  </message>
  <message>
   <source>Loading the sphere</source>
   <translation>Kugel wird geladen</translation>
  </message>
  <message>
   <source>Angle of the light from the normal.</source>
   <translation>Winkel des Lichts zur Normalen.</translation>
  </message>
  <message>
   <source>Evaluating BRDFs</source>
   <translation>BRDFs werden ausgewertet</translation>
  </message>
  <message>
   <source>Integrating albedos</source>
   <translation>Albedos werden integriert</translation>
  </message>
  <message>
   <source>Checking a BRDF</source>
   <translation>BRDF wird geprüft</translation>
  </message>
  <message>
   <source>Looking for files</source>
   <translation>Dateien werden gesucht</translation>
  </message>
  <message>
   <source>Angle of the light</source>
   <translation>Winkel des Lichts</translation>
  </message>
  <message>
   <source>Angle of the light from the normal, in the plane of incidence</source>
   <translation>Winkel des Lichts zur Normalen, in der Einfallsebene</translation>
  </message>
  <message>
   <source>Logarithmic</source>
   <translation>Logarithmisch</translation>
  </message>
  <message>
   <source>Logarithmic length: shows dim parts and narrow highlights together (L)</source>
   <translation>Logarithmische Länge: zeigt dunkle Anteile und schmale Glanzlichter zusammen (L)</translation>
  </message>
  <message>
   <source>Linear</source>
   <translation>Linear</translation>
  </message>
  <message>
   <source>Length in proportion to the value (L)</source>
   <translation>Länge proportional zum Wert (L)</translation>
  </message>
  <message>
   <source>Reset the camera</source>
   <translation>Kamera zurücksetzen</translation>
  </message>
  <message>
   <source>Save the plots as SVG and CSV…</source>
   <translation>Diagramme als SVG und CSV speichern…</translation>
  </message>
  <message>
   <source>Lobes</source>
   <translation>Keulen</translation>
  </message>
  <message>
   <source>Plane of incidence</source>
   <translation>Einfallsebene</translation>
  </message>
  <message>
   <source>θh × θd</source>
   <translation>θh × θd</translation>
  </message>
  <message>
   <source>Nothing to compare yet</source>
   <translation>Noch nichts zu vergleichen</translation>
  </message>
  <message>
   <source>Double-click a model, a published material or a file of your own in the library, or drop measured BRDFs here: MERL, RGL, UTIA, Cornell, ASTM, CUReT, ALTA, CSV.</source>
   <translation>In der Bibliothek ein Modell, ein veröffentlichtes Material oder eine eigene Datei doppelklicken oder gemessene BRDFs hierher ziehen: MERL, RGL, UTIA, Cornell, ASTM, CUReT, ALTA, CSV.</translation>
  </message>
  <message>
   <source>%1, and lobes in space need it. The other views work without.</source>
   <translation>%1, und Keulen im Raum brauchen es. Die anderen Ansichten funktionieren ohne.</translation>
  </message>
  <message>
   <source>Remove %1</source>
   <translation>%1 entfernen</translation>
  </message>
  <message>
   <source>Hide</source>
   <translation>Verbergen</translation>
  </message>
  <message>
   <source>Change %1</source>
   <translation>%1 ändern</translation>
  </message>
  <message>
   <source>brdf %1</source>
   <translation>brdf %1</translation>
  </message>
  <message>
   <source>Write %1</source>
   <translation>%1 schreiben</translation>
  </message>
  <message>
   <source>%1 sr⁻¹</source>
   <translation>%1 sr⁻¹</translation>
  </message>
  <message>
   <source>light at %1°, longest %2 sr⁻¹</source>
   <translation>Licht bei %1°, längste %2 sr⁻¹</translation>
  </message>
  <message>
   <source>theta_o / °</source>
   <translation>theta_o / °</translation>
  </message>
  <message>
   <source>Saving plots to %1</source>
   <translation>Diagramme werden nach %1 gespeichert</translation>
  </message>
  <message>
   <source>Text of the BRDF</source>
   <translation>Text der BRDF</translation>
  </message>
  <message>
   <source>%1, written in GLSL</source>
   <translation>%1, in GLSL geschrieben</translation>
  </message>
  <message>
   <source>Compiling GLSL</source>
   <translation>GLSL wird kompiliert</translation>
  </message>
  <message>
   <source>Save as…</source>
   <translation>Speichern unter…</translation>
  </message>
  <message>
   <source>As a .brdf file, which opens here and in BRDF Explorer</source>
   <translation>Als .brdf-Datei, die sich hier und in BRDF Explorer öffnen lässt</translation>
  </message>
  <message>
   <source>Compiles half a second after the last key</source>
   <translation>Kompiliert eine halbe Sekunde nach der letzten Taste</translation>
  </message>
  <message>
   <source>Compiled</source>
   <translation>Kompiliert</translation>
  </message>
  <message>
   <source>Save the text</source>
   <translation>Text speichern</translation>
  </message>
  <message>
   <source>BRDF Explorer (*.brdf)</source>
   <translation>BRDF Explorer (*.brdf)</translation>
  </message>
  <message>
   <source>Evaluating GLSL</source>
   <translation>GLSL wird ausgewertet</translation>
  </message>
  <message>
   <source>Parameter %1 of the text</source>
   <translation>Parameter %1 des Textes</translation>
  </message>
 </context>
 <context>
  <name>factor</name>
  <message>
   <source>drawing textures</source>
   <translation>Texturen werden gezeichnet</translation>
  </message>
  <message>
   <source>half vector</source>
   <translation>Halbvektor</translation>
  </message>
  <message>
   <source>of the mean</source>
   <translation>des Mittels</translation>
  </message>
  <message>
   <source>%1%2 sr⁻½</source>
   <translation>%1%2 sr⁻½</translation>
  </message>
  <message>
   <source>Textures of the factors</source>
   <translation>Texturen der Faktoren</translation>
  </message>
  <message>
   <source>Each texture, its term and the value of white; hatched texels hold no direction. Click: use terms up to it</source>
   <translation>Jede Textur, ihr Term und der Wert für Weiß; schraffierte Texel haben keine Richtung. Klick: Terme bis dorthin verwenden</translation>
  </message>
  <message>
   <source>Projections of the textures</source>
   <translation>Projektionen der Texturen</translation>
  </message>
  <message>
   <source>Blue and orange are the two coordinates of a texture: each grows along its arrow in the disks of both directions, seen from above</source>
   <translation>Blau und Orange sind die beiden Koordinaten einer Textur: jede wächst entlang ihres Pfeils in den Scheiben beider Richtungen, von oben gesehen</translation>
  </message>
  <message>
   <source>%1%2 maps</source>
   <translation>%1%2 Karten</translation>
  </message>
  <message>
   <source>%1, %2 of them</source>
   <translation>%1, davon %2</translation>
  </message>
  <message>
   <source>Start a run first</source>
   <translation>Zuerst einen Lauf beginnen</translation>
  </message>
  <message>
   <source>Export…</source>
   <translation>Exportieren…</translation>
  </message>
  <message>
   <source>Use in View</source>
   <translation>In Ansicht nutzen</translation>
  </message>
  <message>
   <source>Runs</source>
   <translation>Läufe</translation>
  </message>
  <message>
   <source>The chosen run is previewed and exported; Del removes it</source>
   <translation>Der gewählte Lauf wird gezeigt und exportiert; Entf entfernt ihn</translation>
  </message>
  <message>
   <source>Del</source>
   <translation>Entf</translation>
  </message>
  <message>
   <source>Space</source>
   <translation>Leertaste</translation>
  </message>
  <message>
   <source>Pause</source>
   <translation>Anhalten</translation>
  </message>
  <message>
   <source>Stop</source>
   <translation>Beenden</translation>
  </message>
  <message>
   <source>Remove the run</source>
   <translation>Lauf entfernen</translation>
  </message>
  <message>
   <source>Terms to go on to</source>
   <translation>Terme, bis zu denen fortgesetzt wird</translation>
  </message>
  <message>
   <source>Continue</source>
   <translation>Fortsetzen</translation>
  </message>
  <message>
   <source>Up to terms</source>
   <translation>Bis Terme</translation>
  </message>
  <message>
   <source>Add terms; a search continues from its last state</source>
   <translation>Terme hinzufügen; eine Suche setzt bei ihrem letzten Stand fort</translation>
  </message>
  <message>
   <source>Chosen factors</source>
   <translation>Gewählte Faktoren</translation>
  </message>
  <message>
   <source>The run and the method</source>
   <translation>Der Lauf und das Verfahren</translation>
  </message>
  <message>
   <source>Terms</source>
   <translation>Terme</translation>
  </message>
  <message>
   <source>Click a point of the plot for others; and how many textures these are</source>
   <translation>Klick auf einen Punkt des Diagramms wählt andere; und wie viele Texturen das sind</translation>
  </message>
  <message>
   <source>Of all textures, as 32-bit floats</source>
   <translation>Aller Texturen, als 32-Bit-Gleitkommazahlen</translation>
  </message>
  <message>
   <source>Time</source>
   <translation>Zeit</translation>
  </message>
  <message>
   <source>From the start to this term, without pauses; the products of a sum are all found at once</source>
   <translation>Vom Anfang bis zu diesem Term, ohne Pausen; die Produkte einer Summe entstehen alle zugleich</translation>
  </message>
  <message>
   <source>Error by the viewer's elevation</source>
   <translation>Fehler nach Elevation des Blicks</translation>
  </message>
  <message>
   <source>Good for</source>
   <translation>Gut für</translation>
  </message>
  <message>
   <source>It has ended</source>
   <translation>Er ist beendet</translation>
  </message>
  <message>
   <source>Factor again</source>
   <translation>Neu faktorisieren</translation>
  </message>
  <message>
   <source>Resume</source>
   <translation>Fortsetzen</translation>
  </message>
  <message>
   <source>Pause and let other jobs run, or resume (Space in the list)</source>
   <translation>Anhalten, damit andere Aufträge laufen, oder fortsetzen (Leertaste in der Liste)</translation>
  </message>
  <message>
   <source>Factor with the settings of this run</source>
   <translation>Mit den Einstellungen dieses Laufs faktorisieren</translation>
  </message>
  <message>
   <source>End now and keep the best so far</source>
   <translation>Jetzt beenden und das bisher Beste behalten</translation>
  </message>
  <message>
   <source>Remove the run from the list (Del); undo restores it</source>
   <translation>Den Lauf von der Liste entfernen (Entf); Rückgängig stellt ihn wieder her</translation>
  </message>
  <message>
   <source>It is still running</source>
   <translation>Er läuft noch</translation>
  </message>
  <message>
   <source>These factors come from a file; start a run for more terms</source>
   <translation>Diese Faktoren stammen aus einer Datei; für mehr Terme einen Lauf beginnen</translation>
  </message>
  <message>
   <source>%1 has no further terms</source>
   <translation>%1 hat keine weiteren Terme</translation>
  </message>
  <message>
   <source>It ended before it began</source>
   <translation>Er endete, bevor er begann</translation>
  </message>
  <message>
   <source>%1 terms are the most</source>
   <translation>Höchstens %1 Terme</translation>
  </message>
  <message>
   <source>Continue up to this number of terms</source>
   <translation>Bis zu dieser Zahl von Termen fortsetzen</translation>
  </message>
  <message>
   <source>Nothing has been found yet</source>
   <translation>Noch nichts gefunden</translation>
  </message>
  <message>
   <source>Write the textures as EXR and their description as JSON, into a folder</source>
   <translation>Die Texturen als EXR und ihre Beschreibung als JSON in einen Ordner schreiben</translation>
  </message>
  <message>
   <source>Use these factors as the BRDF of the material in the View workspace</source>
   <translation>Diese Faktoren als BRDF des Materials im Arbeitsbereich Ansicht verwenden</translation>
  </message>
  <message>
   <source>%1 of %2 · %3 texture%4</source>
   <translation>%1 von %2 · %3 Textur</translation>
  </message>
  <message>
   <source>Elevation / °</source>
   <translation>Elevation / °</translation>
  </message>
  <message>
   <source>RMS / sr⁻¹</source>
   <translation>RMS / sr⁻¹</translation>
  </message>
  <message>
   <source>Cosine-weighted RMS at this elevation of the viewer</source>
   <translation>Kosinusgewichteter RMS bei dieser Elevation des Blicks</translation>
  </message>
  <message>
   <source> from a file</source>
   <translation> aus einer Datei</translation>
  </message>
  <message>
   <source>, half/difference</source>
   <translation>, Halb/Differenz</translation>
  </message>
  <message>
   <source>, any</source>
   <translation>, beliebig</translation>
  </message>
  <message>
   <source>%1 map</source>
   <translation>Karte: %1</translation>
  </message>
  <message>
   <source>%1, %2 restarts, %3 together</source>
   <translation>%1, %2 Neustarts, %3 zusammen</translation>
  </message>
  <message>
   <source>makes %1 small</source>
   <translation>macht %1 klein</translation>
  </message>
  <message>
   <source>%1 samples up to %2°, seed %3</source>
   <translation>%1 Abtastungen bis %2°, Startwert %3</translation>
  </message>
  <message>
   <source>nothing found</source>
   <translation>nichts gefunden</translation>
  </message>
  <message>
   <source>a search makes no more textures</source>
   <translation>eine Suche erzeugt keine weiteren Texturen</translation>
  </message>
  <message>
   <source>%1 of %2 terms: %3.</source>
   <translation>%1 von %2 Termen: %3.</translation>
  </message>
  <message>
   <source>Error over the optimum of Eckart and Young: %1</source>
   <translation>Fehler über dem Optimum von Eckart und Young: %1</translation>
  </message>
  <message>
   <source>Asymmetry of the matrix: %1</source>
   <translation>Asymmetrie der Matrix: %1</translation>
  </message>
  <message>
   <source>Condition number: %1</source>
   <translation>Konditionszahl: %1</translation>
  </message>
  <message>
   <source>%1 projections tried</source>
   <translation>%1 Projektionen versucht</translation>
  </message>
  <message>
   <source>RMS × cos is lowest with %1 term%2</source>
   <translation>RMS × cos ist am kleinsten mit %1 Term</translation>
  </message>
  <message>
   <source>; more make it worse and are not stored</source>
   <translation>; mehr verschlechtern ihn und werden nicht gespeichert</translation>
  </message>
  <message>
   <source>Held-out errors are best with %1 term%2%3</source>
   <translation>Validierungsfehler sind am besten mit %1 Term%3</translation>
  </message>
  <message>
   <source>at samples of regions of directions held out in turn, or between texels</source>
   <translation>an Abtastungen nacheinander zurückgehaltener Richtungsbereiche oder zwischen Texeln</translation>
  </message>
  <message>
   <source>over random pairs of directions</source>
   <translation>über zufällige Richtungspaare</translation>
  </message>
  <message>
   <source>over the samples and channels</source>
   <translation>über die Abtastungen und Kanäle</translation>
  </message>
  <message>
   <source>Save plot as PNG, SVG or CSV…</source>
   <translation>Diagramm als PNG, SVG oder CSV speichern…</translation>
  </message>
  <message>
   <source>Number of terms</source>
   <translation>Anzahl der Terme</translation>
  </message>
  <message>
   <source>Time / s</source>
   <translation>Zeit / s</translation>
  </message>
  <message>
   <source>Size / kB</source>
   <translation>Größe / kB</translation>
  </message>
  <message>
   <source>Error of the factors</source>
   <translation>Fehler der Faktoren</translation>
  </message>
  <message>
   <source>Click a point to preview and export that number of terms (left and right arrow keys); right-click to save</source>
   <translation>Klick auf einen Punkt zeigt und exportiert diese Zahl von Termen (Pfeiltasten links und rechts); Rechtsklick speichert</translation>
  </message>
  <message>
   <source>Run</source>
   <translation>Lauf</translation>
  </message>
  <message>
   <source>Method</source>
   <translation>Verfahren</translation>
  </message>
  <message>
   <source>Textures</source>
   <translation>Texturen</translation>
  </message>
  <message>
   <source>Size / B</source>
   <translation>Größe / B</translation>
  </message>
  <message>
   <source>points without an error are not shown</source>
   <translation>Punkte ohne Fehlerwert werden nicht gezeigt</translation>
  </message>
  <message>
   <source>Comparing images</source>
   <translation>Bilder werden verglichen</translation>
  </message>
  <message>
   <source>Factored</source>
   <translation>Faktorisiert</translation>
  </message>
  <message>
   <source>Unfactored</source>
   <translation>Original</translation>
  </message>
  <message>
   <source>Difference</source>
   <translation>Differenz</translation>
  </message>
  <message>
   <source>Model, %1</source>
   <translation>Modell, %1</translation>
  </message>
  <message>
   <source>nothing found yet</source>
   <translation>noch nichts gefunden</translation>
  </message>
  <message>
   <source>nothing yet</source>
   <translation>noch nichts</translation>
  </message>
  <message>
   <source>%1, RMS %2</source>
   <translation>%1, RMS %2</translation>
  </message>
  <message>
   <source>Difference of the two images</source>
   <translation>Unterschied der beiden Bilder</translation>
  </message>
  <message>
   <source>Luminance, factored minus unfactored: orange where the factors are too bright, blue where too dark</source>
   <translation>Leuchtdichte, faktorisiert minus Original: orange, wo die Faktoren zu hell sind, blau, wo zu dunkel</translation>
  </message>
  <message>
   <source>This has been factored with these settings already: the list has it</source>
   <translation>Das wurde mit diesen Einstellungen schon faktorisiert: es steht in der Liste</translation>
  </message>
  <message>
   <source>%1 waits for %2</source>
   <translation>%1 wartet auf %2</translation>
  </message>
  <message>
   <source>%1 runs are listed at most; remove one first</source>
   <translation>Höchstens %1 Läufe werden aufgelistet; zuerst einen entfernen</translation>
  </message>
  <message>
   <source>The BRDF is no longer in the list of the BRDF workspace</source>
   <translation>Die BRDF ist nicht mehr in der Liste des Arbeitsbereichs BRDF</translation>
  </message>
  <message>
   <source>Its result is missing from the data folder: factor again</source>
   <translation>Das Ergebnis fehlt im Datenordner: neu faktorisieren</translation>
  </message>
  <message>
   <source>Choose %1</source>
   <translation>%1 wählen</translation>
  </message>
  <message>
   <source>Factor %1: %2</source>
   <translation>%1 faktorisieren: %2</translation>
  </message>
  <message>
   <source>%1 terms of %2</source>
   <translation>%1 Terme von %2</translation>
  </message>
  <message>
   <source>Opening %1</source>
   <translation>%1 wird geöffnet</translation>
  </message>
  <message>
   <source>Open factors %1</source>
   <translation>Faktoren %1 öffnen</translation>
  </message>
  <message>
   <source>Factoring %1: %2</source>
   <translation>%1 wird faktorisiert: %2</translation>
  </message>
  <message>
   <source>factors %1</source>
   <translation>Faktoren %1</translation>
  </message>
  <message>
   <source>Reading factors</source>
   <translation>Faktoren werden gelesen</translation>
  </message>
  <message>
   <source>not finished</source>
   <translation>nicht beendet</translation>
  </message>
  <message>
   <source>%1 of the material</source>
   <translation>%1 des Materials</translation>
  </message>
  <message>
   <source>compiling (first use only)</source>
   <translation>wird kompiliert (nur beim ersten Mal)</translation>
  </message>
  <message>
   <source>Choose another method or other settings</source>
   <translation>Ein anderes Verfahren oder andere Einstellungen wählen</translation>
  </message>
  <message>
   <source>reading factors</source>
   <translation>Faktoren werden gelesen</translation>
  </message>
  <message>
   <source>What the BRDF workspace compares, its files, models and published materials; type to find one</source>
   <translation>Was der Arbeitsbereich BRDF vergleicht, seine Dateien, Modelle und veröffentlichten Materialien; tippen, um zu suchen</translation>
  </message>
  <message>
   <source>Restarts</source>
   <translation>Neustarts</translation>
  </message>
  <message>
   <source>Together</source>
   <translation>Zusammen</translation>
  </message>
  <message>
   <source>Max. angle</source>
   <translation>Max. Winkel</translation>
  </message>
  <message>
   <source>Seed</source>
   <translation>Startwert</translation>
  </message>
  <message>
   <source>Factor</source>
   <translation>Faktorisieren</translation>
  </message>
  <message>
   <source>Open factors…</source>
   <translation>Öffnen…</translation>
  </message>
  <message>
   <source>A folder of factors that was exported here or by lightarc factor</source>
   <translation>Ein Ordner mit Faktoren, der hier oder mit „lightarc factor“ exportiert wurde</translation>
  </message>
  <message>
   <source>BRDF to factor</source>
   <translation>Zu faktorisierende BRDF</translation>
  </message>
  <message>
   <source>Factors</source>
   <translation>Faktoren</translation>
  </message>
  <message>
   <source>Directions</source>
   <translation>Richtungen</translation>
  </message>
  <message>
   <source>The two directions that index the textures</source>
   <translation>Die beiden Richtungen, nach denen die Texturen indiziert sind</translation>
  </message>
  <message>
   <source>Map from the hemisphere to a square of texels</source>
   <translation>Abbildung der Halbkugel auf ein Quadrat von Texeln</translation>
  </message>
  <message>
   <source>Enforced</source>
   <translation>Erzwungen</translation>
  </message>
  <message>
   <source>Reciprocal</source>
   <translation>Reziprok</translation>
  </message>
  <message>
   <source>Enforces reciprocity exactly: each texture is read for both orders of light and view</source>
   <translation>Erzwingt exakte Reziprozität: jede Textur wird für beide Reihenfolgen von Licht und Blick gelesen</translation>
  </message>
  <message>
   <source>Minimises</source>
   <translation>Minimiert</translation>
  </message>
  <message>
   <source>The error by which the search chooses projections. Logarithms count dark and bright alike, and the cosine-weighted RMS, which bright values dominate, can rise with them; Mean² weighs bright values most</source>
   <translation>Der Fehler, nach dem die Suche Projektionen wählt. Logarithmen zählen dunkel und hell gleich; der kosinusgewichtete RMS, den helle Werte bestimmen, kann dabei steigen; Mittel² gewichtet helle Werte am stärksten</translation>
  </message>
  <message>
   <source>Preset</source>
   <translation>Vorgabe</translation>
  </message>
  <message>
   <source>Ours adds guesses, fixed projections and a final fit of all textures to what the thesis did</source>
   <translation>„Eigene“ ergänzt die Dissertation um Startwerte, feste Projektionen und eine letzte Anpassung aller Texturen</translation>
  </message>
  <message>
   <source>Begin with these settings (Ctrl+Enter)</source>
   <translation>Mit diesen Einstellungen beginnen (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>PNG image (*.png);;SVG drawing (*.svg);;Values as CSV (*.csv)</source>
   <translation>PNG-Bild (*.png);;SVG-Zeichnung (*.svg);;Werte als CSV (*.csv)</translation>
  </message>
  <message>
   <source>Drawing textures</source>
   <translation>Texturen werden gezeichnet</translation>
  </message>
  <message>
   <source>Judging factors</source>
   <translation>Faktoren werden bewertet</translation>
  </message>
  <message>
   <source>Plotted error</source>
   <translation>Gezeigter Fehler</translation>
  </message>
  <message>
   <source>The error that the plot shows</source>
   <translation>Der Fehler, den das Diagramm zeigt</translation>
  </message>
  <message>
   <source>Error against the number of terms</source>
   <translation>Fehler über der Anzahl der Terme</translation>
  </message>
  <message>
   <source>Error against time, with every intermediate result</source>
   <translation>Fehler über der Zeit, mit jedem Zwischenergebnis</translation>
  </message>
  <message>
   <source>Error against the bytes of the textures</source>
   <translation>Fehler über den Bytes der Texturen</translation>
  </message>
  <message>
   <source>Exposure of the textures</source>
   <translation>Belichtung der Texturen</translation>
  </message>
  <message>
   <source>Brightness of the textures</source>
   <translation>Helligkeit der Texturen</translation>
  </message>
  <message>
   <source>Preview on a sphere</source>
   <translation>Vorschau auf einer Kugel</translation>
  </message>
  <message>
   <source>Preview on the model of the View workspace</source>
   <translation>Vorschau auf dem Modell des Arbeitsbereichs Ansicht</translation>
  </message>
  <message>
   <source>Projections</source>
   <translation>Projektionen</translation>
  </message>
  <message>
   <source>Preview</source>
   <translation>Vorschau</translation>
  </message>
  <message>
   <source>Nothing factored yet</source>
   <translation>Noch nichts faktorisiert</translation>
  </message>
  <message>
   <source>Choose a BRDF and a method on the left and press Factor. Several methods can run side by side; their errors, textures and projections appear here while they run.</source>
   <translation>Links eine BRDF und ein Verfahren wählen und „Faktorisieren“ drücken. Mehrere Verfahren können nebeneinander laufen; ihre Fehler, Texturen und Projektionen erscheinen hier währenddessen.</translation>
  </message>
  <message>
   <source>Choose %1 term%2 of %3</source>
   <translation>%1 Term von %3 wählen</translation>
  </message>
  <message>
   <source>Factor %1 next</source>
   <translation>%1 als Nächstes faktorisieren</translation>
  </message>
  <message>
   <source>Change how to factor</source>
   <translation>Faktorisierung ändern</translation>
  </message>
  <message>
   <source>factor choices</source>
   <translation>factor choices</translation>
  </message>
  <message>
   <source>Remove a run of %1</source>
   <translation>Einen Lauf von %1 entfernen</translation>
  </message>
  <message>
   <source>Open a folder of factors</source>
   <translation>Einen Ordner mit Faktoren öffnen</translation>
  </message>
  <message>
   <source>%1 factors</source>
   <translation>Faktoren von %1</translation>
  </message>
  <message>
   <source>Export factors to a new folder</source>
   <translation>Faktoren in einen neuen Ordner exportieren</translation>
  </message>
  <message>
   <source>Writing %1</source>
   <translation>%1 wird geschrieben</translation>
  </message>
  <message>
   <source>%1, %2 term%3</source>
   <translation>%1, %2 Term</translation>
  </message>
  <message>
   <source>Save the error plot</source>
   <translation>Fehlerdiagramm speichern</translation>
  </message>
  <message>
   <source>Load a model in the View workspace first</source>
   <translation>Zuerst im Arbeitsbereich Ansicht ein Modell laden</translation>
  </message>
 </context>
 <context>
  <name>view</name>
  <message>
   <source>Bake</source>
   <translation>Vorberechnen</translation>
  </message>
  <message>
   <source>Compute the light transport at each vertex, in the background (Ctrl+Enter)</source>
   <translation>Den Lichttransport an jedem Eckpunkt im Hintergrund berechnen (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>Stop baking</source>
   <translation>Vorberechnung beenden</translation>
  </message>
  <message>
   <source>Forced under Effects</source>
   <translation>Unter „Effekte“ festgelegt</translation>
  </message>
  <message>
   <source>A bake is running</source>
   <translation>Eine Vorberechnung läuft</translation>
  </message>
  <message>
   <source>%1, then it bakes.</source>
   <translation>%1, danach wird vorberechnet.</translation>
  </message>
  <message>
   <source>Analysing the scene</source>
   <translation>Szene wird untersucht</translation>
  </message>
  <message>
   <source>Preparing</source>
   <translation>Vorbereitung</translation>
  </message>
  <message>
   <source>%1. Until then the image shows %2.</source>
   <translation>%1. Bis dahin zeigt das Bild %2.</translation>
  </message>
  <message>
   <source>Waiting</source>
   <translation>Wartet</translation>
  </message>
  <message>
   <source>Baked in %1</source>
   <translation>In %1 vorberechnet</translation>
  </message>
  <message>
   <source>Baked</source>
   <translation>Vorberechnet</translation>
  </message>
  <message>
   <source>Light and camera move freely.</source>
   <translation>Licht und Kamera sind frei beweglich.</translation>
  </message>
  <message>
   <source>Estimating…</source>
   <translation>Wird geschätzt…</translation>
  </message>
  <message>
   <source>Baking takes about %1 and %2.</source>
   <translation>Die Vorberechnung braucht etwa %1 und %2.</translation>
  </message>
  <message>
   <source>This was not baked yet.</source>
   <translation>Noch nicht vorberechnet.</translation>
  </message>
  <message>
   <source>Until then the image shows %1.</source>
   <translation>Bis dahin zeigt das Bild %1.</translation>
  </message>
  <message>
   <source>Another BRDF takes about %1.</source>
   <translation>Eine andere BRDF braucht etwa %1.</translation>
  </message>
  <message>
   <source>Error %1 in the %2</source>
   <translation>Fehler %1 in: %2</translation>
  </message>
  <message>
   <source>%1: another mode, or more of this one, shows this BRDF better.</source>
   <translation>%1: ein anderer Modus oder eine feinere Einstellung zeigt diese BRDF besser.</translation>
  </message>
  <message>
   <source>Not shown: %1.</source>
   <translation>Nicht gezeigt: %1.</translation>
  </message>
  <message>
   <source>The plan leaves off %1: switch off under Effects.</source>
   <translation>Der Plan lässt %1 weg: unter „Effekte“ ausschalten.</translation>
  </message>
  <message>
   <source> (error %1 in the studio)</source>
   <translation> (Fehler %1 im Studio)</translation>
  </message>
  <message>
   <source> without interreflection</source>
   <translation> ohne Wechselreflexion</translation>
  </message>
  <message>
   <source>a first image in spherical harmonics%1%2</source>
   <translation>ein erstes Bild in Kugelflächenfunktionen%1%2</translation>
  </message>
  <message>
   <source>the previous bake</source>
   <translation>die vorige Vorberechnung</translation>
  </message>
  <message>
   <source>direct light without shadows</source>
   <translation>direktes Licht ohne Schatten</translation>
  </message>
  <message>
   <source>The image keeps the light before: %1.</source>
   <translation>Das Bild behält das vorige Licht: %1.</translation>
  </message>
  <message>
   <source>What is baked is kept, and the next bake goes on from there.</source>
   <translation>Berechnetes bleibt erhalten; die nächste Vorberechnung setzt dort fort.</translation>
  </message>
  <message>
   <source>Estimating a bake</source>
   <translation>Vorberechnung wird geschätzt</translation>
  </message>
  <message>
   <source>Relighting</source>
   <translation>Neu beleuchten</translation>
  </message>
  <message>
   <source>Settings of %1</source>
   <translation>Einstellungen: %1</translation>
  </message>
  <message>
   <source>The bake is of another model.</source>
   <translation>Die Vorberechnung gehört zu einem anderen Modell.</translation>
  </message>
  <message>
   <source>The bake is of another ground.</source>
   <translation>Die Vorberechnung gehört zu einem anderen Boden.</translation>
  </message>
  <message>
   <source>The bake is of other materials of the parts.</source>
   <translation>Die Vorberechnung gehört zu anderen Materialien der Teile.</translation>
  </message>
  <message>
   <source>Baking %1</source>
   <translation>Vorberechnung: %1</translation>
  </message>
  <message>
   <source>bakes that follow</source>
   <translation>folgende Vorberechnungen</translation>
  </message>
  <message>
   <source>Nothing is written if you stop it.</source>
   <translation>Bei einem Abbruch wird nichts geschrieben.</translation>
  </message>
  <message>
   <source>In the integral</source>
   <translation>Im Integral</translation>
  </message>
  <message>
   <source>The slice is sampled at r = BRDF × cosine, as the method defines it</source>
   <translation>Die Schicht wird bei r = BRDF × Kosinus abgetastet, wie es das Verfahren vorsieht</translation>
  </message>
  <message>
   <source>Texture</source>
   <translation>Textur</translation>
  </message>
  <message>
   <source>The brightest slice, used as a texture</source>
   <translation>Die hellste Schicht, als Textur verwendet</translation>
  </message>
  <message>
   <source>By outgoing radiance</source>
   <translation>Nach Strahldichte</translation>
  </message>
  <message>
   <source>The slice is sampled at the outgoing radiance</source>
   <translation>Die Schicht wird bei der ausgehenden Strahldichte abgetastet</translation>
  </message>
  <message>
   <source>By angle</source>
   <translation>Nach Winkel</translation>
  </message>
  <message>
   <source>The slice is sampled at the angle of the light alone</source>
   <translation>Die Schicht wird nur beim Winkel des Lichts abgetastet</translation>
  </message>
  <message>
   <source>A model, or a BRDF from the BRDF workspace</source>
   <translation>Ein Modell oder eine BRDF aus dem Arbeitsbereich BRDF</translation>
  </message>
  <message>
   <source>Multiple scattering</source>
   <translation>Mehrfachstreuung</translation>
  </message>
  <message>
   <source>Add the light that rough facets of the PBR maps scatter more than once</source>
   <translation>Das Licht hinzufügen, das raue Facetten der PBR-Karten mehrfach streuen</translation>
  </message>
  <message>
   <source>BRDF %1</source>
   <translation>BRDF %1</translation>
  </message>
  <message>
   <source>Change BRDF</source>
   <translation>BRDF ändern</translation>
  </message>
  <message>
   <source>Sampling</source>
   <translation>Abtastung</translation>
  </message>
  <message>
   <source>Sample the slices of the shading map</source>
   <translation>Die Schichten der Schattierungskarte abtasten</translation>
  </message>
  <message>
   <source>Sample the compressed pair, six numbers per texel</source>
   <translation>Das komprimierte Paar abtasten, sechs Zahlen je Texel</translation>
  </message>
  <message>
   <source>P. law</source>
   <translation>Potenz</translation>
  </message>
  <message>
   <source>Show from</source>
   <translation>Zeigen aus</translation>
  </message>
  <message>
   <source>The four ways of sampling of Kautz et al. 2004, figure 6</source>
   <translation>Die vier Arten der Abtastung nach Kautz et al. 2004, Abbildung 6</translation>
  </message>
  <message>
   <source>Clamp</source>
   <translation>Kappen</translation>
  </message>
  <message>
   <source>Brighter than the brightest photograph: that photograph</source>
   <translation>Heller als das hellste Foto: dieses Foto</translation>
  </message>
  <message>
   <source>Brighter than the brightest photograph: scaled up</source>
   <translation>Heller als das hellste Foto: hochskaliert</translation>
  </message>
  <message>
   <source>Above the largest r</source>
   <translation>Über dem größten r</translation>
  </message>
  <message>
   <source>Above</source>
   <translation>Darüber</translation>
  </message>
  <message>
   <source>Sampling above the largest r of the capture</source>
   <translation>Abtastung über dem größten r der Aufnahme</translation>
  </message>
  <message>
   <source>Scale σ</source>
   <translation>Maßstab σ</translation>
  </message>
  <message>
   <source>Automatic: model and photographs agree on the capture's own lights</source>
   <translation>Automatisch: Modell und Fotos stimmen unter den Lichtern der Aufnahme überein</translation>
  </message>
  <message>
   <source>A directional map is shown by its planes</source>
   <translation>Eine Richtungskarte wird durch ihre Ebenen gezeigt</translation>
  </message>
  <message>
   <source>Build or open a material first</source>
   <translation>Zuerst ein Material erzeugen oder öffnen</translation>
  </message>
  <message>
   <source>PBR maps have a BRDF at each texel and no slices</source>
   <translation>PBR-Karten haben an jedem Texel eine BRDF und keine Schichten</translation>
  </message>
  <message>
   <source>%1 auto</source>
   <translation>%1 autom.</translation>
  </message>
  <message>
   <source>Direct light only</source>
   <translation>Nur direktes Licht</translation>
  </message>
  <message>
   <source>1 bounce</source>
   <translation>1 Reflexion</translation>
  </message>
  <message>
   <source>2 bounces</source>
   <translation>2 Reflexionen</translation>
  </message>
  <message>
   <source>4 bounces</source>
   <translation>4 Reflexionen</translation>
  </message>
  <message>
   <source>8 bounces</source>
   <translation>8 Reflexionen</translation>
  </message>
  <message>
   <source>Off</source>
   <translation>Aus</translation>
  </message>
  <message>
   <source>Only the mode above</source>
   <translation>Nur der Modus oben</translation>
  </message>
  <message>
   <source>Wipe</source>
   <translation>Linie</translation>
  </message>
  <message>
   <source>Both modes, separated by a line that you drag (B)</source>
   <translation>Beide Modi, getrennt durch eine ziehbare Linie (B)</translation>
  </message>
  <message>
   <source>The luminance of the mode above minus that of the other (E)</source>
   <translation>Die Leuchtdichte des Modus oben minus die des anderen (E)</translation>
  </message>
  <message>
   <source>Compare</source>
   <translation>Vergleich</translation>
  </message>
  <message>
   <source>Compare with</source>
   <translation>Vergleichen mit</translation>
  </message>
  <message>
   <source>Against</source>
   <translation>Gegen</translation>
  </message>
  <message>
   <source>The other mode; Tab exchanges the two while both are shown</source>
   <translation>Der andere Modus; Tab vertauscht die beiden, solange beide gezeigt werden</translation>
  </message>
  <message>
   <source>Bounces</source>
   <translation>Reflexionen</translation>
  </message>
  <message>
   <source>Path depth of the reference: bounces after the first surface. All errors are measured against it</source>
   <translation>Pfadtiefe der Referenz: Reflexionen nach der ersten Fläche. Alle Fehler werden daran gemessen</translation>
  </message>
  <message>
   <source>Relative RMSE of linear radiance against the other, and its 95 % confidence interval</source>
   <translation>Relativer RMSE der linearen Strahldichte gegenüber dem anderen Bild, mit 95-%-Konfidenzintervall</translation>
  </message>
  <message>
   <source>FLIP: difference seen when the two images alternate, from 0 (none) to 1 (all)</source>
   <translation>FLIP: Unterschied, der beim Wechsel zwischen den Bildern zu sehen ist, von 0 (keiner) bis 1 (alles)</translation>
  </message>
  <message>
   <source>Largest</source>
   <translation>Größter</translation>
  </message>
  <message>
   <source>The largest difference of a channel, in radiance</source>
   <translation>Der größte Unterschied eines Kanals, in Strahldichte</translation>
  </message>
  <message>
   <source>Both are the same: choose another under Against</source>
   <translation>Beide sind gleich: unter „Gegen“ einen anderen wählen</translation>
  </message>
  <message>
   <source>being measured</source>
   <translation>wird gemessen</translation>
  </message>
  <message>
   <source>The true error lies within ± of this value in 95 % of all cases.</source>
   <translation>Der wahre Fehler liegt in 95 % aller Fälle innerhalb ± dieses Werts.</translation>
  </message>
  <message>
   <source>The images are not complete yet</source>
   <translation>Die Bilder sind noch nicht fertig</translation>
  </message>
  <message>
   <source>noise of the reference</source>
   <translation>Rauschen der Referenz</translation>
  </message>
  <message>
   <source>%1 against %2</source>
   <translation>%1 gegen %2</translation>
  </message>
  <message>
   <source>the reference</source>
   <translation>die Referenz</translation>
  </message>
  <message>
   <source>%1 pixels</source>
   <translation>%1 Pixel</translation>
  </message>
  <message>
   <source>%1 sample%2</source>
   <translation>%1 Abtastung</translation>
  </message>
  <message>
   <source>The noise of the reference after %1 of each of %2.
%3</source>
   <translation>Das Rauschen der Referenz nach %1 von %2.
%3</translation>
  </message>
  <message>
   <source>%1: relative RMSE of linear radiance on %2</source>
   <translation>%1: relativer RMSE der linearen Strahldichte auf %2</translation>
  </message>
  <message>
   <source>%1; the reference has %2 of each.
%3</source>
   <translation>%1; die Referenz hat jeweils %2.
%3</translation>
  </message>
  <message>
   <source> It is measured once the image rests.</source>
   <translation> Gemessen wird, sobald das Bild ruht.</translation>
  </message>
  <message>
   <source>The error that the plan predicts: %1 in 95 of 100 scenes.%2</source>
   <translation>Der vorhergesagte Fehler des Plans: %1 in 95 von 100 Szenen.%2</translation>
  </message>
  <message>
   <source>≈ %1 predicted</source>
   <translation>≈ %1 vorhergesagt</translation>
  </message>
  <message>
   <source>There is no reference to compare with. %1.</source>
   <translation>Es gibt keine Referenz zum Vergleich. %1.</translation>
  </message>
  <message>
   <source>Measured against a reference that refines in the background, once the image rests</source>
   <translation>Gemessen an einer Referenz, die im Hintergrund verfeinert wird, sobald das Bild ruht</translation>
  </message>
  <message>
   <source>Drawing a first image</source>
   <translation>Erstes Bild wird gezeichnet</translation>
  </message>
  <message>
   <source>measuring the error</source>
   <translation>Fehler wird gemessen</translation>
  </message>
  <message>
   <source>Comparing images as an eye does</source>
   <translation>Bilder werden wahrnehmungsnah verglichen</translation>
  </message>
  <message>
   <source>comparing images</source>
   <translation>Bilder werden verglichen</translation>
  </message>
  <message>
   <source>weighing noise</source>
   <translation>Rauschen wird gewichtet</translation>
  </message>
  <message>
   <source>Rendering the reference</source>
   <translation>Referenz wird berechnet</translation>
  </message>
  <message>
   <source>reference %1</source>
   <translation>Referenz %1</translation>
  </message>
  <message>
   <source>%1, stopped</source>
   <translation>%1, angehalten</translation>
  </message>
  <message>
   <source>%1 does not show the near lights, which the reference shows</source>
   <translation>%1 zeigt die nahen Lichter nicht, die die Referenz zeigt</translation>
  </message>
  <message>
   <source>The reference does not show spatial variation of the BRDF</source>
   <translation>Die Referenz zeigt die räumliche Variation der BRDF nicht</translation>
  </message>
  <message>
   <source>Solid colour</source>
   <translation>Einfarbig</translation>
  </message>
  <message>
   <source>Environment</source>
   <translation>Umgebung</translation>
  </message>
  <message>
   <source>Blurred a little</source>
   <translation>Leicht unscharf</translation>
  </message>
  <message>
   <source>Blurred</source>
   <translation>Unscharf</translation>
  </message>
  <message>
   <source>Facing elevation</source>
   <translation>Elevation (Ziel)</translation>
  </message>
  <message>
   <source>Facing azimuth</source>
   <translation>Azimut (Ziel)</translation>
  </message>
  <message>
   <source>One light, or an environment; .hdr and .exr files can be dropped here</source>
   <translation>Ein Licht oder eine Umgebung; .hdr- und .exr-Dateien können hierher gezogen werden</translation>
  </message>
  <message>
   <source>Irradiance</source>
   <translation>Bestr.-Stärke</translation>
  </message>
  <message>
   <source>Rotation</source>
   <translation>Drehung</translation>
  </message>
  <message>
   <source>Strength</source>
   <translation>Stärke</translation>
  </message>
  <message>
   <source>Number of lights that represent the environment: more are more accurate and slower</source>
   <translation>Anzahl der Lichter, die die Umgebung darstellen: mehr sind genauer und langsamer</translation>
  </message>
  <message>
   <source>Behind</source>
   <translation>Dahinter</translation>
  </message>
  <message>
   <source>What is seen behind the model</source>
   <translation>Was hinter dem Modell zu sehen ist</translation>
  </message>
  <message>
   <source>Error of these directions against the whole environment, on this image</source>
   <translation>Fehler dieser Richtungen gegenüber der ganzen Umgebung, auf diesem Bild</translation>
  </message>
  <message>
   <source>More lights; drag their suns in the image</source>
   <translation>Weitere Lichter; ihre Sonnen lassen sich im Bild ziehen</translation>
  </message>
  <message>
   <source>Extra lights</source>
   <translation>Zusatzlichter</translation>
  </message>
  <message>
   <source>Extra light</source>
   <translation>Zusatzlicht</translation>
  </message>
  <message>
   <source>a light: directional, or a disc with soft shadows</source>
   <translation>ein Licht: gerichtet oder eine Scheibe mit weichen Schatten</translation>
  </message>
  <message>
   <source>Spheres, rectangles and discs of light near the model; drag their rings in the image</source>
   <translation>Leuchtende Kugeln, Rechtecke und Scheiben nahe am Modell; ihre Ringe lassen sich im Bild ziehen</translation>
  </message>
  <message>
   <source>Near lights</source>
   <translation>Nahe Lichter</translation>
  </message>
  <message>
   <source>Near light</source>
   <translation>Nahes Licht</translation>
  </message>
  <message>
   <source>a light near the model</source>
   <translation>ein Licht nahe am Modell</translation>
  </message>
  <message>
   <source>One light</source>
   <translation>Ein Licht</translation>
  </message>
  <message>
   <source>Extra lights only</source>
   <translation>Nur Zusatzlichter</translation>
  </message>
  <message>
   <source>Open an environment…</source>
   <translation>Umgebung öffnen…</translation>
  </message>
  <message>
   <source>Add an extra light</source>
   <translation>Zusatzlicht hinzufügen</translation>
  </message>
  <message>
   <source>Remove an extra light</source>
   <translation>Zusatzlicht entfernen</translation>
  </message>
  <message>
   <source>Add a near light</source>
   <translation>Nahes Licht hinzufügen</translation>
  </message>
  <message>
   <source>Remove a near light</source>
   <translation>Nahes Licht entfernen</translation>
  </message>
  <message>
   <source>Behind the model</source>
   <translation>Hinter dem Modell</translation>
  </message>
  <message>
   <source>Open an environment</source>
   <translation>Umgebung öffnen</translation>
  </message>
  <message>
   <source>Environments</source>
   <translation>Umgebungen</translation>
  </message>
  <message>
   <source>Light from %1</source>
   <translation>Licht aus %1</translation>
  </message>
  <message>
   <source>Add %1</source>
   <translation>Hinzufügen: %1</translation>
  </message>
  <message>
   <source>Remove this %1</source>
   <translation>Entfernen: %1</translation>
  </message>
  <message>
   <source>None</source>
   <translation>Ohne</translation>
  </message>
  <message>
   <source>There are no %1s yet</source>
   <translation>Es gibt noch keines: %1</translation>
  </message>
  <message>
   <source>There are %1 %2s already</source>
   <translation>Es sind schon %1: %2</translation>
  </message>
  <message>
   <source>Click the model to choose a vertex. Its lobes are those of a bake in Gaussians, or else fitted to one view.</source>
   <translation>Klick auf das Modell wählt einen Eckpunkt. Seine Keulen sind die einer Vorberechnung mit Gauß-Funktionen oder an eine Ansicht angepasst.</translation>
  </message>
  <message>
   <source>This BRDF has no glossy part.</source>
   <translation>Diese BRDF hat keinen glänzenden Anteil.</translation>
  </message>
  <message>
   <source>This vertex faces away from this view.</source>
   <translation>Dieser Eckpunkt ist von dieser Ansicht abgewandt.</translation>
  </message>
  <message>
   <source>Click the model to choose a vertex.</source>
   <translation>Klick auf das Modell wählt einen Eckpunkt.</translation>
  </message>
  <message>
   <source>Click the model</source>
   <translation>Modell anklicken</translation>
  </message>
  <message>
   <source>Not glossy</source>
   <translation>Nicht glänzend</translation>
  </message>
  <message>
   <source>Faces away</source>
   <translation>Abgewandt</translation>
  </message>
  <message>
   <source>Lobe inspector</source>
   <translation>Keulen-Inspektor</translation>
  </message>
  <message>
   <source>Inspecting a vertex</source>
   <translation>Eckpunkt wird untersucht</translation>
  </message>
  <message>
   <source>The camera</source>
   <translation>Die Kamera</translation>
  </message>
  <message>
   <source>View %1</source>
   <translation>Ansicht %1</translation>
  </message>
  <message>
   <source>View</source>
   <translation>Ansicht</translation>
  </message>
  <message>
   <source>Direction of the view: the camera, or one of the 92 stored views</source>
   <translation>Blickrichtung: die Kamera oder eine der 92 gespeicherten Ansichten</translation>
  </message>
  <message>
   <source>Towards</source>
   <translation>Richtung</translation>
  </message>
  <message>
   <source>seen %1° from the normal</source>
   <translation>%1° von der Normalen gesehen</translation>
  </message>
  <message>
   <source>lobes of the bake</source>
   <translation>Keulen der Vorberechnung</translation>
  </message>
  <message>
   <source>lobes fitted to this view alone</source>
   <translation>nur an diese Ansicht angepasste Keulen</translation>
  </message>
  <message>
   <source>Vertex %1</source>
   <translation>Eckpunkt %1</translation>
  </message>
  <message>
   <source>Tabulated transport</source>
   <translation>Tabellierter Transport</translation>
  </message>
  <message>
   <source>to %1 / sr</source>
   <translation>bis %1 / sr</translation>
  </message>
  <message>
   <source>error %1</source>
   <translation>Fehler %1</translation>
  </message>
  <message>
   <source>%1, %2 numbers</source>
   <translation>%1, %2 Zahlen</translation>
  </message>
  <message>
   <source>Lobes of a vertex</source>
   <translation>Keulen eines Eckpunkts</translation>
  </message>
  <message>
   <source>looking at the model</source>
   <translation>Modell wird untersucht</translation>
  </message>
  <message>
   <source>Analysing the scene…</source>
   <translation>Szene wird untersucht…</translation>
  </message>
  <message>
   <source>this scene could not be planned</source>
   <translation>für diese Szene ließ sich kein Plan machen</translation>
  </message>
  <message>
   <source>Planning was stopped. Any change of the scene or of the budget plans again.</source>
   <translation>Die Planung wurde beendet. Jede Änderung der Szene oder des Budgets plant neu.</translation>
  </message>
  <message>
   <source>Planning effects</source>
   <translation>Effekte werden geplant</translation>
  </message>
  <message>
   <source>A plan needs an environment: choose one under Light.</source>
   <translation>Ein Plan braucht eine Umgebung: unter „Licht“ eine wählen.</translation>
  </message>
  <message>
   <source>Enter the budget as '1 %' or '8 ms'.</source>
   <translation>Das Budget als „1 %“ oder „8 ms“ eingeben.</translation>
  </message>
  <message>
   <source>A plan keeps within an error or a time: give only one of the two.</source>
   <translation>Ein Plan hält einen Fehler oder eine Zeit ein: nur eines von beiden angeben.</translation>
  </message>
  <message>
   <source>Plain grey</source>
   <translation>Grau</translation>
  </message>
  <message>
   <source>Transparent</source>
   <translation>Transparent</translation>
  </message>
  <message>
   <source>The model</source>
   <translation>Das Modell</translation>
  </message>
  <message>
   <source>The light</source>
   <translation>Das Licht</translation>
  </message>
  <message>
   <source>Both together</source>
   <translation>Beides zusammen</translation>
  </message>
  <message>
   <source>PNG (*.png);;OpenEXR, linear radiance (*.exr)</source>
   <translation>PNG (*.png);;OpenEXR, lineare Strahldichte (*.exr)</translation>
  </message>
  <message>
   <source>MP4 (*.mp4);;Animated WebP (*.webp);;Folder of PNG (*)</source>
   <translation>MP4 (*.mp4);;Animiertes WebP (*.webp);;Ordner mit PNG (*)</translation>
  </message>
  <message>
   <source>Save an image</source>
   <translation>Bild speichern</translation>
  </message>
  <message>
   <source>Save a turntable</source>
   <translation>Drehung speichern</translation>
  </message>
  <message>
   <source>Image</source>
   <translation>Bild</translation>
  </message>
  <message>
   <source>One image</source>
   <translation>Ein Bild</translation>
  </message>
  <message>
   <source>Turntable</source>
   <translation>Drehung</translation>
  </message>
  <message>
   <source>A film of one turn</source>
   <translation>Ein Film einer ganzen Drehung</translation>
  </message>
  <message>
   <source>As on screen, %1 × %2</source>
   <translation>Wie am Bildschirm, %1 × %2</translation>
  </message>
  <message>
   <source>Any size: images beyond the limit of the graphics device come in tiles</source>
   <translation>Beliebige Größe: Bilder über der Grenze der Grafikkarte entstehen in Kacheln</translation>
  </message>
  <message>
   <source>Background</source>
   <translation>Hintergrund</translation>
  </message>
  <message>
   <source>What is behind the model</source>
   <translation>Was hinter dem Modell ist</translation>
  </message>
  <message>
   <source>Blur</source>
   <translation>Unschärfe</translation>
  </message>
  <message>
   <source>Blur of the environment behind the model, as an angle; the light stays as it is</source>
   <translation>Unschärfe der Umgebung hinter dem Modell, als Winkel; das Licht bleibt unverändert</translation>
  </message>
  <message>
   <source>Paths of each pixel: four times as many halve the noise</source>
   <translation>Pfade je Pixel: viermal so viele halbieren das Rauschen</translation>
  </message>
  <message>
   <source>Albedo and normals in .exr</source>
   <translation>Albedo und Normalen in .exr</translation>
  </message>
  <message>
   <source>Layers in the same file; the reference always has its standard error</source>
   <translation>Ebenen in derselben Datei; die Referenz hat immer ihren Standardfehler</translation>
  </message>
  <message>
   <source>What turns</source>
   <translation>Was sich dreht</translation>
  </message>
  <message>
   <source>The model before a light that rests, the light, or both as one</source>
   <translation>Das Modell vor ruhendem Licht, das Licht oder beides als Ganzes</translation>
  </message>
  <message>
   <source>Of one full turn</source>
   <translation>Einer ganzen Drehung</translation>
  </message>
  <message>
   <source>Frames/s</source>
   <translation>Bilder/s</translation>
  </message>
  <message>
   <source>Save…</source>
   <translation>Speichern…</translation>
  </message>
  <message>
   <source>Choose a place, and draw in the background</source>
   <translation>Einen Ort wählen und im Hintergrund zeichnen</translation>
  </message>
  <message>
   <source>Cancel</source>
   <translation>Abbrechen</translation>
  </message>
  <message>
   <source>Only an environment behind the model can be blurred</source>
   <translation>Nur eine Umgebung hinter dem Modell kann unscharf sein</translation>
  </message>
  <message>
   <source>Only the reference draws with random paths</source>
   <translation>Nur die Referenz zeichnet mit zufälligen Pfaden</translation>
  </message>
  <message>
   <source>%1 frames, drawn as %2.</source>
   <translation>%1 Bilder, gezeichnet mit: %2.</translation>
  </message>
  <message>
   <source>Drawn as %1.</source>
   <translation>Gezeichnet mit: %1.</translation>
  </message>
  <message>
   <source>Plane</source>
   <translation>Ebene</translation>
  </message>
  <message>
   <source>Torus knot</source>
   <translation>Torusknoten</translation>
  </message>
  <message>
   <source>Draped cloth</source>
   <translation>Drapiertes Tuch</translation>
  </message>
  <message>
   <source>Abstract bust</source>
   <translation>Abstrakte Büste</translation>
  </message>
  <message>
   <source>Flat, once</source>
   <translation>Flach, einmal</translation>
  </message>
  <message>
   <source>Along the texture</source>
   <translation>Längs der Textur</translation>
  </message>
  <message>
   <source>Along %1</source>
   <translation>Längs %1</translation>
  </message>
  <message>
   <source>Scene</source>
   <translation>Szene</translation>
  </message>
  <message>
   <source>A built-in model, or a mesh of your own</source>
   <translation>Ein eingebautes Modell oder ein eigenes Netz</translation>
  </message>
  <message>
   <source>Flip it</source>
   <translation>Umdrehen</translation>
  </message>
  <message>
   <source>Flip the faces, so that the surface faces outwards</source>
   <translation>Die Flächen umdrehen, sodass die Oberfläche nach außen zeigt</translation>
  </message>
  <message>
   <source>Tiling</source>
   <translation>Kachelung</translation>
  </message>
  <message>
   <source>Grid</source>
   <translation>Raster</translation>
  </message>
  <message>
   <source>Each repeat of the maps is the same</source>
   <translation>Jede Wiederholung der Karten ist gleich</translation>
  </message>
  <message>
   <source>Hexagonal</source>
   <translation>Hexagonal</translation>
  </message>
  <message>
   <source>In hexagonal cells without a visible period, for materials without a regular pattern</source>
   <translation>In sechseckigen Zellen ohne sichtbare Periode, für Materialien ohne regelmäßiges Muster</translation>
  </message>
  <message>
   <source>Tiling mode</source>
   <translation>Kachelart</translation>
  </message>
  <message>
   <source>How the material repeats over the model</source>
   <translation>Wie sich das Material über das Modell wiederholt</translation>
  </message>
  <message>
   <source>Brushing</source>
   <translation>Bürstung</translation>
  </message>
  <message>
   <source>The direction along which an anisotropic BRDF runs</source>
   <translation>Die Richtung, in der eine anisotrope BRDF verläuft</translation>
  </message>
  <message>
   <source>Angle</source>
   <translation>Winkel</translation>
  </message>
  <message>
   <source>Brushing the model</source>
   <translation>Modell wird gebürstet</translation>
  </message>
  <message>
   <source>Ground</source>
   <translation>Boden</translation>
  </message>
  <message>
   <source>A level diffuse surface under the model</source>
   <translation>Eine ebene diffuse Fläche unter dem Modell</translation>
  </message>
  <message>
   <source>Open a mesh…</source>
   <translation>Netz öffnen…</translation>
  </message>
  <message>
   <source>Meshes</source>
   <translation>Netze</translation>
  </message>
  <message>
   <source>Open a mesh</source>
   <translation>Netz öffnen</translation>
  </message>
  <message>
   <source>Flipping the model</source>
   <translation>Modell wird umgedreht</translation>
  </message>
  <message>
   <source>Flip the model</source>
   <translation>Modell umdrehen</translation>
  </message>
  <message>
   <source>brushing the model</source>
   <translation>Modell wird gebürstet</translation>
  </message>
  <message>
   <source>flipping the model</source>
   <translation>Modell wird umgedreht</translation>
  </message>
  <message>
   <source>Neutral (Khronos)</source>
   <translation>Neutral (Khronos)</translation>
  </message>
  <message>
   <source>No shadows on the ground in this mode and light: baked modes and the reference show them.</source>
   <translation>Bei diesem Modus und Licht hat der Boden keine Schatten: vorberechnete Modi und die Referenz zeigen sie.</translation>
  </message>
  <message>
   <source>%1 does not show near lights: choose Direct, the reference or spherical harmonics.</source>
   <translation>%1 zeigt keine nahen Lichter: „Direkt“, die Referenz oder Kugelfunktionen wählen.</translation>
  </message>
  <message>
   <source>Measuring the light's error</source>
   <translation>Fehler des Lichts wird gemessen</translation>
  </message>
  <message>
   <source>Blurring the environment</source>
   <translation>Umgebung wird weichgezeichnet</translation>
  </message>
  <message>
   <source>Frame the model</source>
   <translation>Modell einpassen</translation>
  </message>
  <message>
   <source>Swap the two modes</source>
   <translation>Die beiden Modi vertauschen</translation>
  </message>
  <message>
   <source>Tab</source>
   <translation>Tab</translation>
  </message>
  <message>
   <source>Tone map</source>
   <translation>Tonwerte</translation>
  </message>
  <message>
   <source>Tone mapping of radiance above white</source>
   <translation>Tonwertabbildung von Strahldichten über Weiß</translation>
  </message>
  <message>
   <source>Stop refining the reference</source>
   <translation>Verfeinern der Referenz anhalten</translation>
  </message>
  <message>
   <source>Loading the model</source>
   <translation>Modell wird geladen</translation>
  </message>
  <message>
   <source>No material yet: the model shows the BRDF alone.</source>
   <translation>Noch kein Material: das Modell zeigt nur die BRDF.</translation>
  </message>
  <message>
   <source>Direct light shows the BRDF at the mean of the PBR maps.</source>
   <translation>Direktes Licht zeigt die BRDF beim Mittel der PBR-Karten.</translation>
  </message>
  <message>
   <source>Measured BRDF: %1</source>
   <translation>Gemessene BRDF: %1</translation>
  </message>
  <message>
   <source>%1 triangles</source>
   <translation>%1 Dreiecke</translation>
  </message>
  <message>
   <source>Refine the reference again</source>
   <translation>Referenz weiter verfeinern</translation>
  </message>
  <message>
   <source>The reference is not being refined</source>
   <translation>Die Referenz wird nicht verfeinert</translation>
  </message>
  <message>
   <source>Use %1</source>
   <translation>%1 verwenden</translation>
  </message>
  <message>
   <source>Rotate the environment</source>
   <translation>Umgebung drehen</translation>
  </message>
  <message>
   <source>Change the light</source>
   <translation>Licht ändern</translation>
  </message>
  <message>
   <source>Change the image</source>
   <translation>Bild ändern</translation>
  </message>
  <message>
   <source>Change a light</source>
   <translation>Ein Licht ändern</translation>
  </message>
  <message>
   <source>Move the light</source>
   <translation>Licht bewegen</translation>
  </message>
  <message>
   <source>There is no environment: choose one under Light</source>
   <translation>Es gibt keine Umgebung: unter „Licht“ eine wählen</translation>
  </message>
  <message>
   <source>Keep this view</source>
   <translation>Diese Ansicht merken</translation>
  </message>
  <message>
   <source>Forget</source>
   <translation>Vergessen</translation>
  </message>
  <message>
   <source>Keep %1</source>
   <translation>%1 merken</translation>
  </message>
  <message>
   <source>Forget %1</source>
   <translation>%1 vergessen</translation>
  </message>
 </context>
 <context>
  <name>export</name>
  <message>
   <source>Relative RMSE against the material itself under studio, noon and overcast</source>
   <translation>Relativer RMSE gegenüber dem Material selbst unter Studio, Mittag und bedecktem Himmel</translation>
  </message>
  <message>
   <source>Mean difference that a user sees, against the material itself under the same environments</source>
   <translation>Mittlerer sichtbarer Unterschied gegenüber dem Material selbst unter denselben Umgebungen</translation>
  </message>
  <message>
   <source>Relative RMSE against the photographs, each under its own lamp, seen from above</source>
   <translation>Relativer RMSE gegenüber den Fotos, jedes unter seiner Lampe, von oben gesehen</translation>
  </message>
  <message>
   <source>Bytes of all files</source>
   <translation>Bytes aller Dateien</translation>
  </message>
  <message>
   <source>Bytes per point</source>
   <translation>Bytes je Punkt</translation>
  </message>
  <message>
   <source>Bytes of the maps that shading one point reads: what its evaluation costs</source>
   <translation>Bytes der Karten, die ein Punkt beim Schattieren liest: die Kosten der Auswertung</translation>
  </message>
  <message>
   <source>%1, on a preview sphere</source>
   <translation>%1, auf einer Vorschaukugel</translation>
  </message>
  <message>
   <source>It shows no image of the surface</source>
   <translation>Es zeigt kein Bild der Oberfläche</translation>
  </message>
  <message>
   <source>Targets of an export</source>
   <translation>Ziele eines Exports</translation>
  </message>
  <message>
   <source>Title</source>
   <translation>Titel</translation>
  </message>
  <message>
   <source>Title of the work</source>
   <translation>Titel des Werks</translation>
  </message>
  <message>
   <source>Author</source>
   <translation>Urheber</translation>
  </message>
  <message>
   <source>Who made it</source>
   <translation>Wer es gemacht hat</translation>
  </message>
  <message>
   <source>License</source>
   <translation>Lizenz</translation>
  </message>
  <message>
   <source>An SPDX identifier as CC-BY-4.0, or words</source>
   <translation>Ein SPDX-Kürzel wie CC-BY-4.0 oder Text</translation>
  </message>
  <message>
   <source>An address or a reference</source>
   <translation>Eine Adresse oder ein Verweis</translation>
  </message>
  <message>
   <source>Credits</source>
   <translation>Angaben</translation>
  </message>
  <message>
   <source>%1; written into all files of an export</source>
   <translation>%1; wird in alle Dateien eines Exports geschrieben</translation>
  </message>
  <message>
   <source>Blender</source>
   <translation>Blender</translation>
  </message>
  <message>
   <source>Unreal</source>
   <translation>Unreal</translation>
  </message>
  <message>
   <source>Unity</source>
   <translation>Unity</translation>
  </message>
  <message>
   <source>Godot</source>
   <translation>Godot</translation>
  </message>
  <message>
   <source>Substance</source>
   <translation>Substance</translation>
  </message>
  <message>
   <source>PNG, 8 bits</source>
   <translation>PNG, 8 Bit</translation>
  </message>
  <message>
   <source>PNG, 16 bits</source>
   <translation>PNG, 16 Bit</translation>
  </message>
  <message>
   <source>As the program</source>
   <translation>Wie das Programm</translation>
  </message>
  <message>
   <source>y up (OpenGL)</source>
   <translation>y nach oben (OpenGL)</translation>
  </message>
  <message>
   <source>y down (DirectX)</source>
   <translation>y nach unten (DirectX)</translation>
  </message>
  <message>
   <source>Errors are relative, and measured on a preview sphere under three environments.</source>
   <translation>Fehler sind relativ und auf einer Vorschaukugel unter drei Umgebungen gemessen.</translation>
  </message>
  <message>
   <source>Looking for measured export errors</source>
   <translation>Gemessene Exportfehler werden gesucht</translation>
  </message>
  <message>
   <source>Measuring the export error</source>
   <translation>Exportfehler wird gemessen</translation>
  </message>
  <message>
   <source>The material itself</source>
   <translation>Das Material selbst</translation>
  </message>
  <message>
   <source>What a bundle holds; all others are compared with it</source>
   <translation>Was ein Paket enthält; alle anderen werden damit verglichen</translation>
  </message>
  <message>
   <source>Export error</source>
   <translation>Exportfehler</translation>
  </message>
  <message>
   <source>Measure export error</source>
   <translation>Exportfehler messen</translation>
  </message>
  <message>
   <source>Stop measuring. What was measured is kept</source>
   <translation>Messung beenden. Gemessenes bleibt erhalten</translation>
  </message>
  <message>
   <source>Smallest format under this error</source>
   <translation>Kleinstes Format unter diesem Fehler</translation>
  </message>
  <message>
   <source>Error of an export</source>
   <translation>Fehler eines Exports</translation>
  </message>
  <message>
   <source>Relative RMSE against the material itself that is still good enough</source>
   <translation>Relativer RMSE gegenüber dem Material selbst, der noch gut genug ist</translation>
  </message>
  <message>
   <source>Choose</source>
   <translation>Wählen</translation>
  </message>
  <message>
   <source>Program</source>
   <translation>Programm</translation>
  </message>
  <message>
   <source>Names and packing as its importer expects them</source>
   <translation>Namen und Packung, wie sein Importer sie erwartet</translation>
  </message>
  <message>
   <source>Bits of a value; OpenEXR holds half floats</source>
   <translation>Bits eines Werts; OpenEXR enthält halbe Gleitkommazahlen</translation>
  </message>
  <message>
   <source>Direction of y in the map of normals</source>
   <translation>Richtung von y in der Normalenkarte</translation>
  </message>
  <message>
   <source>Settings of textures</source>
   <translation>Einstellungen der Texturen</translation>
  </message>
  <message>
   <source>1 × 1, the sample</source>
   <translation>1 × 1, die Probe</translation>
  </message>
  <message>
   <source>Tile of exports</source>
   <translation>Kachel der Exporte</translation>
  </message>
  <message>
   <source>A larger tile whose repeats all differ, for programs that repeat maps in a grid</source>
   <translation>Eine größere Kachel, deren Wiederholungen sich alle unterscheiden, für Programme, die Karten im Raster wiederholen</translation>
  </message>
  <message>
   <source>Tile</source>
   <translation>Kachel</translation>
  </message>
  <message>
   <source>Repeats</source>
   <translation>Wiederholungen</translation>
  </message>
  <message>
   <source>%1; errors are measured with the export</source>
   <translation>%1; Fehler werden beim Export gemessen</translation>
  </message>
  <message>
   <source>Web page</source>
   <translation>Webseite</translation>
  </message>
  <message>
   <source>not known</source>
   <translation>unbekannt</translation>
  </message>
  <message>
   <source>Width of the sample, for a scale bar; empty where it is not known</source>
   <translation>Breite der Probe, für einen Maßstabsbalken; leer, wenn unbekannt</translation>
  </message>
  <message>
   <source>Folder</source>
   <translation>Ordner</translation>
  </message>
  <message>
   <source>Name</source>
   <translation>Name</translation>
  </message>
  <message>
   <source>A folder with one folder for each target</source>
   <translation>Ein Ordner mit einem Unterordner je Ziel</translation>
  </message>
  <message>
   <source>Change…</source>
   <translation>Ändern…</translation>
  </message>
  <message>
   <source>Within</source>
   <translation>Innerhalb</translation>
  </message>
  <message>
   <source>Result</source>
   <translation>Ergebnis</translation>
  </message>
  <message>
   <source>Nothing written yet.</source>
   <translation>Noch nichts geschrieben.</translation>
  </message>
  <message>
   <source>Show the folder</source>
   <translation>Ordner zeigen</translation>
  </message>
  <message>
   <source>Export</source>
   <translation>Export</translation>
  </message>
  <message>
   <source>Width of the sample</source>
   <translation>Breite der Probe</translation>
  </message>
  <message>
   <source>%1 exports</source>
   <translation>Exporte von %1</translation>
  </message>
  <message>
   <source>Not measured: see the message.</source>
   <translation>Nicht gemessen: siehe Meldung.</translation>
  </message>
  <message>
   <source>Measuring…</source>
   <translation>Wird gemessen…</translation>
  </message>
  <message>
   <source>Stopped. What was measured is kept.</source>
   <translation>Beendet. Gemessenes bleibt erhalten.</translation>
  </message>
  <message>
   <source>Choose the smallest format</source>
   <translation>Das kleinste Format wählen</translation>
  </message>
  <message>
   <source>keeps it at</source>
   <translation>hält es mit</translation>
  </message>
  <message>
   <source>is nearest, and no representation keeps it:</source>
   <translation>kommt am nächsten, und keine Darstellung hält es ein:</translation>
  </message>
  <message>
   <source> by its %1</source>
   <translation> durch %1</translation>
  </message>
  <message>
   <source>Writing…</source>
   <translation>Wird geschrieben…</translation>
  </message>
  <message>
   <source>Exporting to %1</source>
   <translation>Export nach %1</translation>
  </message>
  <message>
   <source>Not written: %1</source>
   <translation>Nicht geschrieben: %1</translation>
  </message>
  <message>
   <source>Cancelled. Nothing was written.</source>
   <translation>Abgebrochen. Nichts wurde geschrieben.</translation>
  </message>
  <message>
   <source>Goes on after the export.</source>
   <translation>Geht nach dem Export weiter.</translation>
  </message>
  <message>
   <source>%1 written: %2 files, %3.</source>
   <translation>%1 geschrieben: %2 Dateien, %3.</translation>
  </message>
  <message>
   <source>%1 written</source>
   <translation>%1 geschrieben</translation>
  </message>
  <message>
   <source>Folder for the exports</source>
   <translation>Ordner für die Exporte</translation>
  </message>
  <message>
   <source>about %1</source>
   <translation>etwa %1</translation>
  </message>
  <message>
   <source>Measure errors and sizes of %1 targets, %2; kept with the project</source>
   <translation>Fehler und Größen von %1 Zielen messen, %2; bleibt im Projekt</translation>
  </message>
  <message>
   <source>target is</source>
   <translation>Ziel ist</translation>
  </message>
  <message>
   <source>targets are</source>
   <translation>Ziele sind</translation>
  </message>
  <message>
   <source>%1 %2 not measured. Measuring takes %3.</source>
   <translation>%1 %2 nicht gemessen. Messen dauert %3.</translation>
  </message>
  <message>
   <source>Nothing is measured yet</source>
   <translation>Noch nichts ist gemessen</translation>
  </message>
  <message>
   <source>Choose the one that --to auto would write</source>
   <translation>Das Ziel wählen, das --to auto schreiben würde</translation>
  </message>
  <message>
   <source>Export %1 target%2</source>
   <translation>%1 Ziel exportieren</translation>
  </message>
  <message>
   <source>Write a folder with one folder for each target (Ctrl+Enter)</source>
   <translation>Einen Ordner mit einem Unterordner je Ziel schreiben (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>An export is being written</source>
   <translation>Ein Export wird geschrieben</translation>
  </message>
  <message>
   <source>Choose at least one target</source>
   <translation>Mindestens ein Ziel wählen</translation>
  </message>
  <message>
   <source>Give the folder a name without slashes</source>
   <translation>Dem Ordner einen Namen ohne Schrägstriche geben</translation>
  </message>
  <message>
   <source>%1 cannot be written to; choose another folder</source>
   <translation>%1 lässt sich nicht beschreiben; einen anderen Ordner wählen</translation>
  </message>
  <message>
   <source>see the message.</source>
   <translation>siehe Meldung.</translation>
  </message>
  <message>
   <source>Shading map, all slices</source>
   <translation>Schattierungskarte, alle Schichten</translation>
  </message>
  <message>
   <source>needs lamps on an arc</source>
   <translation>braucht Lampen auf einem Bogen</translation>
  </message>
  <message>
   <source>Scale, exponent, map of errors, and the slices of kept tiles</source>
   <translation>Maßstab, Exponent, Fehlerkarte und die Schichten behaltener Kacheln</translation>
  </message>
  <message>
   <source>needs a shading map</source>
   <translation>braucht eine Schattierungskarte</translation>
  </message>
  <message>
   <source>Directional map, all planes</source>
   <translation>Richtungskarte, Ebenen</translation>
  </message>
  <message>
   <source>directional_plane00.png and so on, their numbers and weights</source>
   <translation>directional_plane00.png usw., ihre Zahlen und Gewichte</translation>
  </message>
  <message>
   <source>needs lamps all round</source>
   <translation>braucht Lampen ringsum</translation>
  </message>
  <message>
   <source>pbr_maps.exr, 32-bit floats with their uncertainty</source>
   <translation>pbr_maps.exr, 32-Bit-Gleitkommazahlen mit ihrer Unsicherheit</translation>
  </message>
  <message>
   <source>not made yet</source>
   <translation>noch nicht erzeugt</translation>
  </message>
  <message>
   <source>Shader</source>
   <translation>Shader</translation>
  </message>
  <message>
   <source>shader/lightarc.glsl; PBR maps have none</source>
   <translation>shader/lightarc.glsl; PBR-Karten haben keinen</translation>
  </message>
  <message>
   <source>Viewer for a browser</source>
   <translation>Betrachter für einen Browser</translation>
  </message>
  <message>
   <source>viewer/index.html, which shows the power law or planes under a light that can be dragged; PBR maps have none</source>
   <translation>viewer/index.html, zeigt das Potenzgesetz oder die Ebenen unter beweglichem Licht; PBR-Karten haben keinen</translation>
  </message>
  <message>
   <source>preview.png, as in the View workspace</source>
   <translation>preview.png, wie im Arbeitsbereich Ansicht</translation>
  </message>
  <message>
   <source>Manifest with provenance</source>
   <translation>Manifest mit Herkunft</translation>
  </message>
  <message>
   <source>Bundles (*.lightarc);;Folders (*)</source>
   <translation>Pakete (*.lightarc);;Ordner (*)</translation>
  </message>
  <message>
   <source>Settings were changed after this material was built. Rebuild it in Material before you export it.</source>
   <translation>Einstellungen wurden geändert, nachdem dieses Material erzeugt wurde. Vor dem Export unter „Material“ neu erzeugen.</translation>
  </message>
  <message>
   <source>Spatial variation (View) is kept in the project, not in bundles.</source>
   <translation>Räumliche Variation (Ansicht) bleibt im Projekt, nicht in Paketen.</translation>
  </message>
  <message>
   <source>Drawing the preview</source>
   <translation>Vorschau wird gezeichnet</translation>
  </message>
  <message>
   <source>Nothing to export yet</source>
   <translation>Noch nichts zu exportieren</translation>
  </message>
  <message>
   <source>A bundle holds the material with everything that another program needs to show it. Import photographs first; the material is built from them.</source>
   <translation>Ein Paket enthält das Material mit allem, was ein anderes Programm braucht, um es zu zeigen. Zuerst Fotos importieren; daraus entsteht das Material.</translation>
  </message>
  <message>
   <source>Bundle</source>
   <translation>Paket</translation>
  </message>
  <message>
   <source>The material itself, as one file that this program opens again</source>
   <translation>Das Material selbst, als eine Datei, die dieses Programm wieder öffnet</translation>
  </message>
  <message>
   <source>Other programs</source>
   <translation>Andere Programme</translation>
  </message>
  <message>
   <source>Textures, MaterialX, glTF, USD, shaders, RTI and more, and their losses</source>
   <translation>Texturen, MaterialX, glTF, USD, Shader, RTI und mehr, mit ihren Verlusten</translation>
  </message>
  <message>
   <source>Ends in .lightarc: one file. Otherwise a folder.</source>
   <translation>Endet auf .lightarc: eine Datei. Sonst ein Ordner.</translation>
  </message>
  <message>
   <source>Contents</source>
   <translation>Inhalt</translation>
  </message>
  <message>
   <source>Maps, before packing</source>
   <translation>Karten, vor dem Packen</translation>
  </message>
  <message>
   <source>Export bundle</source>
   <translation>Paket exportieren</translation>
  </message>
  <message>
   <source>Written, but not sound: </source>
   <translation>Geschrieben, aber nicht einwandfrei: </translation>
  </message>
  <message>
   <source>%1 written and verified: %2 members, %3.</source>
   <translation>%1 geschrieben und geprüft: %2 Teile, %3.</translation>
  </message>
  <message>
   <source>%1 written and verified</source>
   <translation>%1 geschrieben und geprüft</translation>
  </message>
  <message>
   <source>Parts of the bundle</source>
   <translation>Teile des Pakets</translation>
  </message>
  <message>
   <source>Folder for the bundle</source>
   <translation>Ordner für das Paket</translation>
  </message>
  <message>
   <source>This material has none: %1</source>
   <translation>Dieses Material hat keine: %1</translation>
  </message>
  <message>
   <source>Replace bundle</source>
   <translation>Paket ersetzen</translation>
  </message>
  <message>
   <source>Write the bundle and check it (Ctrl+Enter)</source>
   <translation>Das Paket schreiben und prüfen (Strg+Eingabe)</translation>
  </message>
  <message>
   <source>The bundle is being written</source>
   <translation>Das Paket wird geschrieben</translation>
  </message>
  <message>
   <source>Choose at least one form of the material</source>
   <translation>Mindestens eine Form des Materials wählen</translation>
  </message>
  <message>
   <source>Give the bundle a name without slashes</source>
   <translation>Dem Paket einen Namen ohne Schrägstriche geben</translation>
  </message>
  <message>
   <source>make them in Material</source>
   <translation>unter „Material“ erzeugen</translation>
  </message>
  <message>
   <source>of other texels</source>
   <translation>anderer Texel</translation>
  </message>
  <message>
   <source>out of date</source>
   <translation>veraltet</translation>
  </message>
  <message>
   <source> and kept tiles</source>
   <translation> und behaltene Kacheln</translation>
  </message>
  <message>
   <source>Power law, %1 bits%2</source>
   <translation>Potenzgesetz, %1 Bit%2</translation>
  </message>
 </context>
 <context>
  <name>varying</name>
  <message>
   <source>Left to right (x)</source>
   <translation>Links nach rechts (x)</translation>
  </message>
  <message>
   <source>Bottom to top (y)</source>
   <translation>Unten nach oben (y)</translation>
  </message>
  <message>
   <source>Back to front (z)</source>
   <translation>Hinten nach vorn (z)</translation>
  </message>
  <message>
   <source>Images</source>
   <translation>Bilder</translation>
  </message>
  <message>
   <source>Open an image</source>
   <translation>Bild öffnen</translation>
  </message>
  <message>
   <source>Open a BRDF</source>
   <translation>BRDF öffnen</translation>
  </message>
  <message>
   <source>BRDFs (*)</source>
   <translation>BRDFs (*)</translation>
  </message>
  <message>
   <source>Mixed in</source>
   <translation>Beigemischt</translation>
  </message>
  <message>
   <source>The other BRDF; the one above has the rest of the weight</source>
   <translation>Die andere BRDF; die obere hat den Rest des Gewichts</translation>
  </message>
  <message>
   <source>Multiplies the radiance, at the texture coordinates of the model</source>
   <translation>Multipliziert die Strahldichte, an den Texturkoordinaten des Modells</translation>
  </message>
  <message>
   <source>Along</source>
   <translation>Entlang</translation>
  </message>
  <message>
   <source>Across the box about the model, or by an image at its coordinates</source>
   <translation>Durch den Quader um das Modell oder nach einem Bild an seinen Koordinaten</translation>
  </message>
  <message>
   <source>From</source>
   <translation>Von</translation>
  </message>
  <message>
   <source>To</source>
   <translation>Bis</translation>
  </message>
  <message>
   <source>Open a file…</source>
   <translation>Datei öffnen…</translation>
  </message>
  <message>
   <source>Another image…</source>
   <translation>Anderes Bild…</translation>
  </message>
  <message>
   <source>By an image…</source>
   <translation>Nach einem Bild…</translation>
  </message>
  <message>
   <source>Parameters that vary across the surface. Spherical harmonics and Gaussians vary parameters; wavelets mix BRDFs</source>
   <translation>Parameter, die über die Oberfläche variieren. Kugelfunktionen und Gauß-Funktionen variieren Parameter; Wavelets mischen BRDFs</translation>
  </message>
  <message>
   <source>Spatial variation</source>
   <translation>Räumliche Variation</translation>
  </message>
  <message>
   <source>Add a spatially varying parameter</source>
   <translation>Räumlich variierenden Parameter hinzufügen</translation>
  </message>
  <message>
   <source>Let this vary no longer</source>
   <translation>Nicht mehr variieren</translation>
  </message>
  <message>
   <source>Varies</source>
   <translation>Variiert</translation>
  </message>
  <message>
   <source>Nothing</source>
   <translation>Nichts</translation>
  </message>
  <message>
   <source>No spatially varying parameter yet</source>
   <translation>Noch kein räumlich variierender Parameter</translation>
  </message>
  <message>
   <source>Mix in another BRDF</source>
   <translation>Eine andere BRDF beimischen</translation>
  </message>
  <message>
   <source>Colours of an image…</source>
   <translation>Farben eines Bildes…</translation>
  </message>
  <message>
   <source>Let a parameter vary</source>
   <translation>Parameter variieren</translation>
  </message>
  <message>
   <source>Mix in a BRDF</source>
   <translation>BRDF beimischen</translation>
  </message>
  <message>
   <source>Colours of an image</source>
   <translation>Farben eines Bildes</translation>
  </message>
  <message>
   <source>Change spatial variation</source>
   <translation>Räumliche Variation ändern</translation>
  </message>
  <message>
   <source>varying %1</source>
   <translation>Variation: %1</translation>
  </message>
 </context>
 <context>
  <name>viewport</name>
  <message>
   <source>Rendering</source>
   <translation>Bild wird berechnet</translation>
  </message>
  <message>
   <source>Showing an image</source>
   <translation>Bild wird gezeigt</translation>
  </message>
  <message>
   <source>rendering on the CPU</source>
   <translation>Bild wird auf der CPU berechnet</translation>
  </message>
  <message>
   <source>showing an image</source>
   <translation>Bild wird gezeigt</translation>
  </message>
  <message>
   <source>OpenGL is not available</source>
   <translation>OpenGL ist nicht verfügbar</translation>
  </message>
  <message>
   <source>OpenGL is %1.%2, and 3.3 is needed</source>
   <translation>OpenGL ist %1.%2; nötig ist 3.3</translation>
  </message>
  <message>
   <source>OpenGL cannot be started</source>
   <translation>OpenGL lässt sich nicht starten</translation>
  </message>
  <message>
   <source>maps in place of others are never loaded</source>
   <translation>maps in place of others are never loaded</translation>
  </message>
  <message>
   <source>Front</source>
   <translation>Vorn</translation>
  </message>
  <message>
   <source>Back</source>
   <translation>Hinten</translation>
  </message>
  <message>
   <source>Top</source>
   <translation>Oben</translation>
  </message>
  <message>
   <source>Viewport</source>
   <translation>Ansichtsfenster</translation>
  </message>
  <message>
   <source>%1. Images are computed on the CPU, more slowly.</source>
   <translation>%1. Bilder werden auf der CPU berechnet, langsamer.</translation>
  </message>
  <message>
   <source>turn light</source>
   <translation>Licht drehen</translation>
  </message>
  <message>
   <source>turn environment</source>
   <translation>Umgebung drehen</translation>
  </message>
  <message>
   <source>drag light</source>
   <translation>Licht ziehen</translation>
  </message>
 </context>
 <context>
  <name>widgets</name>
  <message>
   <source>Alignment</source>
   <translation>Ausrichten</translation>
  </message>
  <message>
   <source>Shift</source>
   <translation>Verschiebung</translation>
  </message>
  <message>
   <source>Shift and turn</source>
   <translation>Verschiebung, Drehung</translation>
  </message>
  <message>
   <source>Affine</source>
   <translation>Affin</translation>
  </message>
  <message>
   <source>Perspective</source>
   <translation>Perspektivisch</translation>
  </message>
  <message>
   <source>Allowed motion between photographs</source>
   <translation>Erlaubte Bewegung zwischen den Fotos</translation>
  </message>
  <message>
   <source>White bal.</source>
   <translation>Weißabgl.</translation>
  </message>
  <message>
   <source>As shot</source>
   <translation>Wie aufgenommen</translation>
  </message>
  <message>
   <source>Grey patch…</source>
   <translation>Graufeld…</translation>
  </message>
  <message>
   <source>White balance of RAW files; a grey patch balances all files</source>
   <translation>Weißabgleich von RAW-Dateien; ein Graufeld gleicht alle Dateien ab</translation>
  </message>
  <message>
   <source>Encoding</source>
   <translation>Kodierung</translation>
  </message>
  <message>
   <source>Transfer function of 8- and 16-bit files; automatic: that of their colour profile, without one sRGB unless capture.toml says linear</source>
   <translation>Tonwertkurve von Dateien mit 8 und 16 Bit; automatisch: die ihres Farbprofils, ohne Profil sRGB, sofern capture.toml nicht „linear“ angibt</translation>
  </message>
  <message>
   <source>Maps in</source>
   <translation>Karten in</translation>
  </message>
  <message>
   <source>Rec.709</source>
   <translation>Rec.709</translation>
  </message>
  <message>
   <source>Rec.2020 if needed</source>
   <translation>Rec.2020 bei Bedarf</translation>
  </message>
  <message>
   <source>Rec.2020</source>
   <translation>Rec.2020</translation>
  </message>
  <message>
   <source>ACEScg</source>
   <translation>ACEScg</translation>
  </message>
  <message>
   <source>Colour space in which maps of the surface are made: colours beyond it do not fit between 0 and 1. Images are shown in that of the screen</source>
   <translation>Farbraum der Oberflächenkarten: Farben außerhalb passen nicht zwischen 0 und 1. Bilder werden im Farbraum des Bildschirms gezeigt</translation>
  </message>
  <message>
   <source>Lens</source>
   <translation>Objektiv</translation>
  </message>
  <message>
   <source>A .lens file that an import has written, by which the distortion of the lens is taken off</source>
   <translation>Eine beim Import geschriebene .lens-Datei, mit der die Verzeichnung des Objektivs herausgerechnet wird</translation>
  </message>
  <message>
   <source>What of the photographs is the object; the background counts in no map and no figure</source>
   <translation>Welcher Teil der Fotos das Objekt ist; der Hintergrund zählt in keiner Karte und keinem Messwert</translation>
  </message>
  <message>
   <source>A photograph without light, which is subtracted</source>
   <translation>Ein Foto ohne Licht, das abgezogen wird</translation>
  </message>
  <message>
   <source>A photograph of an even white surface, which is divided out</source>
   <translation>Ein Foto einer gleichmäßig weißen Fläche, durch das geteilt wird</translation>
  </message>
  <message>
   <source>Colour chart</source>
   <translation>Farbtafel</translation>
  </message>
  <message>
   <source>A classic chart of 24 patches, by which colours are corrected: in a photograph of the capture, in a file of its own under the same lamps, or a .chart file that was saved</source>
   <translation>Eine klassische Tafel mit 24 Feldern, nach der Farben korrigiert werden: in einem Foto der Aufnahme, in einer eigenen Datei unter denselben Lampen oder als gespeicherte .chart-Datei</translation>
  </message>
  <message>
   <source>Alpha channel</source>
   <translation>Alphakanal</translation>
  </message>
  <message>
   <source>As found</source>
   <translation>Wie gefunden</translation>
  </message>
  <message>
   <source>In a photograph</source>
   <translation>In einem Foto</translation>
  </message>
  <message>
   <source>Intensity</source>
   <translation>Intensität</translation>
  </message>
  <message>
   <source>Lamps as they are</source>
   <translation>Lampen unverändert</translation>
  </message>
  <message>
   <source>Equal, by the object</source>
   <translation>Gleich, nach Objekt</translation>
  </message>
  <message>
   <source>Equal, by grey patch</source>
   <translation>Gleich, nach Graufeld</translation>
  </message>
  <message>
   <source>Lamps of a dome differ in intensity, which is divided out: by the smooth change of the object over the lamps, or by a white or grey patch, the one of the white balance</source>
   <translation>Die Lampen einer Kuppel sind verschieden hell; das wird herausgerechnet: nach der stetigen Änderung des Objekts über die Lampen oder nach einem weißen oder grauen Feld, dem des Weißabgleichs</translation>
  </message>
  <message>
   <source>Left and right exchanged</source>
   <translation>Links und rechts vertauscht</translation>
  </message>
  <message>
   <source>Top and bottom exchanged</source>
   <translation>Oben und unten vertauscht</translation>
  </message>
  <message>
   <source>x and y exchanged</source>
   <translation>x und y vertauscht</translation>
  </message>
  <message>
   <source>Turned by 180°</source>
   <translation>Um 180° gedreht</translation>
  </message>
  <message>
   <source>In reverse order</source>
   <translation>In umgekehrter Reihenfolge</translation>
  </message>
  <message>
   <source>Moved on by one</source>
   <translation>Um eins weitergerückt</translation>
  </message>
  <message>
   <source>Moved back by one</source>
   <translation>Um eins zurückgerückt</translation>
  </message>
  <message>
   <source>angles θh, θd</source>
   <translation>Winkel θh, θd</translation>
  </message>
  <message>
   <source>angles θi, θo</source>
   <translation>Winkel θi, θo</translation>
  </message>
  <message>
   <source>angles θo, θi</source>
   <translation>Winkel θo, θi</translation>
  </message>
  <message>
   <source>angles θh, θm</source>
   <translation>Winkel θh, θm</translation>
  </message>
  <message>
   <source>angles θd, θm</source>
   <translation>Winkel θd, θm</translation>
  </message>
  <message>
   <source>cosines of</source>
   <translation>Kosinus der</translation>
  </message>
  <message>
   <source>sines of</source>
   <translation>Sinus der</translation>
  </message>
  <message>
   <source>squares of</source>
   <translation>Quadrate der</translation>
  </message>
  <message>
   <source>rotated angles</source>
   <translation>gedrehte Winkel</translation>
  </message>
  <message>
   <source>rotated sum</source>
   <translation>gedrehte Summe</translation>
  </message>
  <message>
   <source>mirrored sum</source>
   <translation>gespiegelte Summe</translation>
  </message>
  <message>
   <source>Highlight</source>
   <translation>Glanzlicht</translation>
  </message>
  <message>
   <source>Roughness α</source>
   <translation>Rauheit α</translation>
  </message>
  <message>
   <source>Roughness αx</source>
   <translation>Rauheit αx</translation>
  </message>
  <message>
   <source>Roughness αy</source>
   <translation>Rauheit αy</translation>
  </message>
  <message>
   <source>Slope angle σ</source>
   <translation>Neigung σ</translation>
  </message>
  <message>
   <source>Slope m</source>
   <translation>Steigung m</translation>
  </message>
  <message>
   <source>Exponent along</source>
   <translation>Exponent längs</translation>
  </message>
  <message>
   <source>Exponent across</source>
   <translation>Exponent quer</translation>
  </message>
  <message>
   <source>Along surface</source>
   <translation>Längs Fläche</translation>
  </message>
  <message>
   <source>Along normal</source>
   <translation>Längs Normale</translation>
  </message>
  <message>
   <source>Along surface %1</source>
   <translation>Längs Fläche %1</translation>
  </message>
  <message>
   <source>Along normal %1</source>
   <translation>Längs Normale %1</translation>
  </message>
  <message>
   <source>Exponent %1</source>
   <translation>Exponent %1</translation>
  </message>
  <message>
   <source>Diffuse roughness</source>
   <translation>Diffuse Rauheit</translation>
  </message>
  <message>
   <source>Metalness</source>
   <translation>Metallanteil</translation>
  </message>
  <message>
   <source>Specular IOR</source>
   <translation>Brechzahl</translation>
  </message>
  <message>
   <source>Coat IOR</source>
   <translation>Lack-Brechzahl</translation>
  </message>
  <message>
   <source>Film weight</source>
   <translation>Filmanteil</translation>
  </message>
  <message>
   <source>Film thickness</source>
   <translation>Filmdicke</translation>
  </message>
  <message>
   <source>Film IOR</source>
   <translation>Film-Brechzahl</translation>
  </message>
  <message>
   <source>Anisotropy</source>
   <translation>Anisotropie</translation>
  </message>
  <message>
   <source>Coat anisotropy</source>
   <translation>Lack-Anisotropie</translation>
  </message>
  <message>
   <source>Shadows</source>
   <translation>Schatten</translation>
  </message>
  <message>
   <source>Interreflection</source>
   <translation>Wechselreflexion</translation>
  </message>
  <message>
   <source>Gloss</source>
   <translation>Glanz</translation>
  </message>
  <message>
   <source>Sharp light</source>
   <translation>Scharfes Licht</translation>
  </message>
  <message>
   <source>Sun</source>
   <translation>Sonne</translation>
  </message>
  <message>
   <source>Mesostructure</source>
   <translation>Mesostruktur</translation>
  </message>
  <message>
   <source>Varying gloss</source>
   <translation>Variabler Glanz</translation>
  </message>
  <message>
   <source>Fresnel</source>
   <translation>Fresnel</translation>
  </message>
  <message>
   <source>Retro-reflection</source>
   <translation>Rückstrahlung</translation>
  </message>
  <message>
   <source>too long for a number</source>
   <translation>zu lang für eine Zahl</translation>
  </message>
  <message>
   <source>%1 is not a number</source>
   <translation>%1 ist keine Zahl</translation>
  </message>
  <message>
   <source>%1 is not a finite number</source>
   <translation>%1 ist keine endliche Zahl</translation>
  </message>
  <message>
   <source>not a number or a sum, product or quotient of numbers</source>
   <translation>keine Zahl und keine Summe, kein Produkt oder Quotient von Zahlen</translation>
  </message>
  <message>
   <source>Enter a number from %1 to %2, such as 2*3.</source>
   <translation>Eine Zahl von %1 bis %2 eingeben, auch 2*3.</translation>
  </message>
  <message>
   <source>Panel</source>
   <translation>Bereich</translation>
  </message>
  <message>
   <source>Angle of the light above the horizon</source>
   <translation>Winkel des Lichts über dem Horizont</translation>
  </message>
  <message>
   <source>Elevation of the direction that the light faces; −90° is straight down</source>
   <translation>Elevation der Richtung, in die das Licht zeigt; −90° ist senkrecht nach unten</translation>
  </message>
  <message>
   <source>%1: colour</source>
   <translation>%1: Farbe</translation>
  </message>
  <message>
   <source>theta_d / ° by theta_h / °</source>
   <translation>theta_d / ° by theta_h / °</translation>
  </message>
  <message>
   <source>%1 files of plots written to %2</source>
   <translation>%1 Dateien mit Diagrammen nach %2 geschrieben</translation>
  </message>
  <message>
   <source>Elevation of the light / °</source>
   <translation>Elevation des Lichts / °</translation>
  </message>
  <message>
   <source>Mean radiance</source>
   <translation>Mittlere Strahldichte</translation>
  </message>
  <message>
   <source>Click a point to show its photograph, the triangle below it to exclude or include it</source>
   <translation>Klick auf einen Punkt zeigt sein Foto, auf das Dreieck darunter schließt es aus oder ein</translation>
  </message>
  <message>
   <source>r = BRDF × cosine</source>
   <translation>r = BRDF × Kosinus</translation>
  </message>
  <message>
   <source>Radiance of the texel</source>
   <translation>Strahldichte des Texels</translation>
  </message>
  <message>
   <source>Colour scale</source>
   <translation>Farbskala</translation>
  </message>
  <message>
   <source>Appears after import.</source>
   <translation>Erscheint nach dem Import.</translation>
  </message>
  <message>
   <source>Nothing needs attention.</source>
   <translation>Alles in Ordnung.</translation>
  </message>
  <message>
   <source>and %1 more in the log</source>
   <translation>und %1 weitere im Protokoll</translation>
  </message>
  <message>
   <source>Error of the compressed material against its slices</source>
   <translation>Fehler des komprimierten Materials gegenüber seinen Schichten</translation>
  </message>
  <message>
   <source>Health</source>
   <translation>Zustand</translation>
  </message>
  <message>
   <source>Health: note</source>
   <translation>Zustand: Hinweis</translation>
  </message>
  <message>
   <source>Health: check</source>
   <translation>Zustand: prüfen</translation>
  </message>
  <message>
   <source>Health: problem</source>
   <translation>Zustand: Problem</translation>
  </message>
  <message>
   <source>Cancel the running job</source>
   <translation>Den laufenden Auftrag abbrechen</translation>
  </message>
  <message>
   <source>error 10.00 % ± 0.01</source>
   <translation>Fehler 10,00 % ± 0,01</translation>
  </message>
  <message>
   <source>Time of the last frame in the viewport</source>
   <translation>Zeit des letzten Bildes in der Ansicht</translation>
  </message>
  <message>
   <source>1000.0 ms</source>
   <translation>1000.0 ms</translation>
  </message>
  <message>
   <source>Memory that this program holds</source>
   <translation>Speicher, den dieses Programm belegt</translation>
  </message>
  <message>
   <source>99.9 GB</source>
   <translation>99.9 GB</translation>
  </message>
  <message>
   <source>Nothing to report</source>
   <translation>Keine Meldungen</translation>
  </message>
  <message>
   <source>%1 ms</source>
   <translation>%1 ms</translation>
  </message>
  <message>
   <source>Progress of the running job</source>
   <translation>Fortschritt des laufenden Auftrags</translation>
  </message>
  <message>
   <source>%1: stopping…</source>
   <translation>%1: wird beendet…</translation>
  </message>
  <message>
   <source>waiting for %1</source>
   <translation>wartet auf %1</translation>
  </message>
  <message>
   <source>Double-click to enlarge</source>
   <translation>Doppelklick vergrößert</translation>
  </message>
  <message>
   <source>show all views</source>
   <translation>alle Ansichten zeigen</translation>
  </message>
  <message>
   <source>%1 (Esc)</source>
   <translation>%1 (Esc)</translation>
  </message>
 </context>
 <context>
  <name>docks</name>
  <message>
   <source>Enter it as '8 ms and 100 MB' or '1 %'.</source>
   <translation>Als „8 ms und 100 MB“ oder „1 %“ eingeben.</translation>
  </message>
  <message>
   <source>1 min</source>
   <translation>1 min</translation>
  </message>
  <message>
   <source>2 min</source>
   <translation>2 min</translation>
  </message>
  <message>
   <source>5 min</source>
   <translation>5 min</translation>
  </message>
  <message>
   <source>15 min</source>
   <translation>15 min</translation>
  </message>
  <message>
   <source>Accuracy</source>
   <translation>Genauigkeit</translation>
  </message>
  <message>
   <source>Cost on the horizontal axis</source>
   <translation>Kosten auf der waagrechten Achse</translation>
  </message>
  <message>
   <source>1 % or 8 ms, 100 MB</source>
   <translation>1 % oder 8 ms, 100 MB</translation>
  </message>
  <message>
   <source>Budget</source>
   <translation>Budget</translation>
  </message>
  <message>
   <source>Largest error, time or memory: the best setting within it is named. Enter applies it, and measures before where nothing is measured yet</source>
   <translation>Größter Fehler, größte Zeit oder größter Speicher: die beste Einstellung darin wird genannt. Die Eingabetaste übernimmt sie und misst vorher, wo noch nichts gemessen ist</translation>
  </message>
  <message>
   <source>Modes to measure</source>
   <translation>Zu messende Modi</translation>
  </message>
  <message>
   <source>Time to measure for</source>
   <translation>Zeit zum Messen</translation>
  </message>
  <message>
   <source>Time limit; settings that do not fit into it are skipped</source>
   <translation>Zeitgrenze; Einstellungen, die nicht hineinpassen, werden übersprungen</translation>
  </message>
  <message>
   <source>Measure</source>
   <translation>Messen</translation>
  </message>
  <message>
   <source>Draw with all settings and compare with the reference, in the background</source>
   <translation>Mit allen Einstellungen zeichnen und mit der Referenz vergleichen, im Hintergrund</translation>
  </message>
  <message>
   <source>All modes</source>
   <translation>Alle Modi</translation>
  </message>
  <message>
   <source>Stop measuring</source>
   <translation>Messung beenden</translation>
  </message>
  <message>
   <source>There is no model yet</source>
   <translation>Es gibt noch kein Modell</translation>
  </message>
  <message>
   <source>1 was</source>
   <translation>1 wurde</translation>
  </message>
  <message>
   <source>%1 were</source>
   <translation>%1 wurden</translation>
  </message>
  <message>
   <source> %1 skipped: measure for longer.</source>
   <translation> %1 übersprungen: länger messen.</translation>
  </message>
  <message>
   <source>%1 in %2</source>
   <translation>%1 in %2</translation>
  </message>
  <message>
   <source>It is on screen.</source>
   <translation>Sie ist auf dem Bildschirm.</translation>
  </message>
  <message>
   <source>Enter applies it.</source>
   <translation>Die Eingabetaste übernimmt sie.</translation>
  </message>
  <message>
   <source> Spatial variation is not included.</source>
   <translation> Räumliche Variation ist nicht enthalten.</translation>
  </message>
  <message>
   <source> The best within the budget is applied then.</source>
   <translation> Dann wird die beste innerhalb des Budgets übernommen.</translation>
  </message>
  <message>
   <source>%1 setting%2 measured so far.%3</source>
   <translation>%1 Einstellung bisher gemessen.%3</translation>
  </message>
  <message>
   <source>Nothing measured yet. Enter measures and uses the best.</source>
   <translation>Noch nichts gemessen. Die Eingabetaste misst und verwendet die beste.</translation>
  </message>
  <message>
   <source>Nothing measured yet on this scene.</source>
   <translation>An dieser Szene ist noch nichts gemessen.</translation>
  </message>
  <message>
   <source>Measured on another scene: measure again.</source>
   <translation>An einer anderen Szene gemessen: neu messen.</translation>
  </message>
  <message>
   <source>%1 setting%2 at %3 × %4</source>
   <translation>%1 Einstellung bei %3 × %4</translation>
  </message>
  <message>
   <source>, %1 skipped</source>
   <translation>, %1 übersprungen</translation>
  </message>
  <message>
   <source>, %1 take none</source>
   <translation>, %1 ohne Kosten</translation>
  </message>
  <message>
   <source>%1. Click a point to use it.</source>
   <translation>%1. Klick auf einen Punkt verwendet ihn.</translation>
  </message>
  <message>
   <source>Measuring accuracy</source>
   <translation>Genauigkeit wird gemessen</translation>
  </message>
  <message>
   <source>Measure accuracy</source>
   <translation>Genauigkeit messen</translation>
  </message>
  <message>
   <source>%1 setting%2 measured</source>
   <translation>%1 Einstellung gemessen</translation>
  </message>
  <message>
   <source> &amp;nbsp; </source>
   <translation> &amp;nbsp; </translation>
  </message>
  <message>
   <source>Auto</source>
   <translation>Auto</translation>
  </message>
  <message>
   <source>On</source>
   <translation>Ein</translation>
  </message>
  <message>
   <source>Effects</source>
   <translation>Effekte</translation>
  </message>
  <message>
   <source>Effects that the scene needs</source>
   <translation>Effekte, die die Szene braucht</translation>
  </message>
  <message>
   <source>Budget of the plan</source>
   <translation>Budget des Plans</translation>
  </message>
  <message>
   <source>Largest error of an image, '1 %', or longest time of a frame, '8 ms'</source>
   <translation>Größter Fehler eines Bildes, „1 %“, oder längste Zeit eines Bildes, „8 ms“</translation>
  </message>
  <message>
   <source>Use this plan</source>
   <translation>Diesen Plan verwenden</translation>
  </message>
  <message>
   <source>Show the mode with the settings that the plan has chosen</source>
   <translation>Den Modus mit den Einstellungen zeigen, die der Plan gewählt hat</translation>
  </message>
  <message>
   <source>As planned, always on, or always off</source>
   <translation>Wie geplant, immer an oder immer aus</translation>
  </message>
  <message>
   <source>Of the previous scene. %1</source>
   <translation>Zur vorigen Szene. %1</translation>
  </message>
  <message>
   <source>There is no plan yet</source>
   <translation>Es gibt noch keinen Plan</translation>
  </message>
  <message>
   <source>%1: about %2 and %3.</source>
   <translation>%1: etwa %2 und %3.</translation>
  </message>
  <message>
   <source>Nothing keeps within the budget. Best for its cost is %1</source>
   <translation>Nichts hält das Budget ein. Am besten für seine Kosten: %1</translation>
  </message>
  <message>
   <source>From where it was planned, the error is %1 in 95 of 100 scenes that are predicted so.</source>
   <translation>Am Ort der Planung ist der Fehler %1 in 95 von 100 Szenen mit dieser Vorhersage.</translation>
  </message>
  <message>
   <source> The budget is met with a probability of %1.</source>
   <translation> Das Budget wird mit einer Wahrscheinlichkeit von %1 eingehalten.</translation>
  </message>
  <message>
   <source>The plan is what is shown</source>
   <translation>Der Plan wird gezeigt</translation>
  </message>
  <message>
   <source>%1 an image</source>
   <translation>%1 je Bild</translation>
  </message>
  <message>
   <source>%1 to bake</source>
   <translation>%1 Vorberechnung</translation>
  </message>
  <message>
   <source>%1 of memory</source>
   <translation>%1 Speicher</translation>
  </message>
  <message>
   <source>%1 keeps within it, but takes %2.</source>
   <translation>%1 hält es ein, braucht aber %2.</translation>
  </message>
  <message>
   <source>no loss</source>
   <translation>kein Verlust</translation>
  </message>
  <message>
   <source>%1, %2 without it</source>
   <translation>%1, ohne %2</translation>
  </message>
  <message>
   <source>%1, %2 for %3</source>
   <translation>%1, %2 für %3</translation>
  </message>
  <message>
   <source> (and %1 more)</source>
   <translation> (und %1 weitere)</translation>
  </message>
  <message>
   <source>%1: BRDF</source>
   <translation>%1: BRDF</translation>
  </message>
  <message>
   <source>Reading of files</source>
   <translation>Lesen von Dateien</translation>
  </message>
  <message>
   <source>Health of every result</source>
   <translation>Zustand jedes Ergebnisses</translation>
  </message>
  <message>
   <source>Self-test</source>
   <translation>Selbsttest</translation>
  </message>
  <message>
   <source>Run the hard numerical cases on this machine; less than a minute</source>
   <translation>Die schwierigen numerischen Fälle auf diesem Rechner prüfen; weniger als eine Minute</translation>
  </message>
  <message>
   <source>Baked %1</source>
   <translation>Vorberechnet: %1</translation>
  </message>
  <message>
   <source>Nothing has been opened or built yet.</source>
   <translation>Noch nichts wurde geöffnet oder erzeugt.</translation>
  </message>
  <message>
   <source>%1 results, %2 figures.</source>
   <translation>%1 Ergebnisse, %2 Werte.</translation>
  </message>
  <message>
   <source>The self-test was stopped.</source>
   <translation>Der Selbsttest wurde beendet.</translation>
  </message>
  <message>
   <source>%1 of %2 cases fail</source>
   <translation>%1 von %2 Fällen schlagen fehl</translation>
  </message>
  <message>
   <source>All %1 cases pass</source>
   <translation>Alle %1 Fälle bestanden</translation>
  </message>
  <message>
   <source>All %1 cases of the self-test pass.</source>
   <translation>Alle %1 Fälle des Selbsttests bestanden.</translation>
  </message>
  <message>
   <source>%1 of %2 cases of the self-test fail: %3.</source>
   <translation>%1 von %2 Fällen des Selbsttests schlagen fehl: %3.</translation>
  </message>
  <message>
   <source>Jobs</source>
   <translation>Aufträge</translation>
  </message>
  <message>
   <source>Job</source>
   <translation>Auftrag</translation>
  </message>
  <message>
   <source>Now</source>
   <translation>Jetzt</translation>
  </message>
  <message>
   <source>Running and finished tasks appear here.</source>
   <translation>Laufende und beendete Aufträge erscheinen hier.</translation>
  </message>
  <message>
   <source>Cancel: %1</source>
   <translation>Abbrechen: %1</translation>
  </message>
  <message>
   <source>Log</source>
   <translation>Protokoll</translation>
  </message>
  <message>
   <source>Nothing has been logged yet.</source>
   <translation>Noch ist nichts protokolliert.</translation>
  </message>
  <message>
   <source>Error against cost</source>
   <translation>Fehler gegen Kosten</translation>
  </message>
  <message>
   <source>Measured settings appear here</source>
   <translation>Gemessene Einstellungen erscheinen hier</translation>
  </message>
  <message>
   <source>%1
Click to use it</source>
   <translation>%1
Klick verwendet sie</translation>
  </message>
 </context>
 <context>
  <name>window</name>
  <message>
   <source>Lightarc</source>
   <translation>Lightarc</translation>
  </message>
  <message>
   <source>keeps this project as it is and opens %1 in one of its own</source>
   <translation>lässt dieses Projekt unverändert und öffnet %1 in einem eigenen</translation>
  </message>
  <message>
   <source>opens %1 in place of what this project has; Undo brings that back</source>
   <translation>öffnet %1 anstelle des Vorhandenen; „Rückgängig“ bringt es zurück</translation>
  </message>
  <message>
   <source>This project has %1 already.</source>
   <translation>Dieses Projekt enthält bereits %1.</translation>
  </message>
  <message>
   <source>a material</source>
   <translation>ein Material</translation>
  </message>
  <message>
   <source>New project</source>
   <translation>Neues Projekt</translation>
  </message>
  <message>
   <source>Where does %1 belong?

%2</source>
   <translation>Wohin gehört %1?

%2</translation>
  </message>
  <message>
   <source>Use these angles</source>
   <translation>Diese Winkel verwenden</translation>
  </message>
  <message>
   <source>Double-click the angles in the list to enter the real ones, measure them on a mirror sphere, or put an .lp file or capture.toml into the folder of the photographs. If the angles in the list are right, use them.</source>
   <translation>Die wahren Winkel per Doppelklick in der Liste eingeben, an einer Spiegelkugel messen oder eine .lp-Datei oder capture.toml in den Ordner der Fotos legen. Stimmen die Winkel in der Liste, können sie verwendet werden.</translation>
  </message>
  <message>
   <source>Exclude it</source>
   <translation>Ausschließen</translation>
  </message>
  <message>
   <source>Enough photographs remain without it. Or bring a whole copy of it.</source>
   <translation>Ohne dieses bleiben genug Fotos. Oder eine vollständige Kopie bereitstellen.</translation>
  </message>
  <message>
   <source>Use it all the same</source>
   <translation>Trotzdem verwenden</translation>
  </message>
  <message>
   <source>Enough photographs remain without it. If it is as it should be, it can be used all the same.</source>
   <translation>Ohne dieses bleiben genug Fotos. Ist es so gewollt, kann es trotzdem verwendet werden.</translation>
  </message>
  <message>
   <source>Lightarc projects (*%1)</source>
   <translation>Lightarc-Projekte (*%1)</translation>
  </message>
  <message>
   <source>Open project</source>
   <translation>Projekt öffnen</translation>
  </message>
  <message>
   <source>A collected project holds its photographs and opens on any machine.</source>
   <translation>Ein gesammeltes Projekt enthält seine Fotos und lässt sich auf jedem Rechner öffnen.</translation>
  </message>
  <message>
   <source>Is it to hold the results as well, %1? They can be made again there, which takes its time.</source>
   <translation>Soll es auch die Ergebnisse enthalten, %1? Sie lassen sich dort neu erzeugen, was Zeit braucht.</translation>
  </message>
  <message>
   <source>%1 files</source>
   <translation>%1 Dateien</translation>
  </message>
  <message>
   <source>the file %1</source>
   <translation>die Datei %1</translation>
  </message>
  <message>
   <source>%1

It will hold %2 from outside the project's folder. Look at the list first, if the project came from somebody else.</source>
   <translation>%1

Es wird %2 von außerhalb des Projektordners enthalten. Wenn das Projekt von jemand anderem stammt, zuerst die Liste ansehen.</translation>
  </message>
  <message>
   <source>With results</source>
   <translation>Mit Ergebnissen</translation>
  </message>
  <message>
   <source>Without</source>
   <translation>Ohne</translation>
  </message>
  <message>
   <source>What is sound in it can be saved in a new project. The damaged one stays as it is.</source>
   <translation>Was unbeschädigt ist, lässt sich in einem neuen Projekt speichern. Das beschädigte bleibt, wie es ist.</translation>
  </message>
  <message>
   <source>Recover…</source>
   <translation>Wiederherstellen…</translation>
  </message>
  <message>
   <source>History</source>
   <translation>Verlauf</translation>
  </message>
  <message>
   <source>The beginning</source>
   <translation>Der Anfang</translation>
  </message>
  <message>
   <source>Steps of the history</source>
   <translation>Schritte des Verlaufs</translation>
  </message>
  <message>
   <source>Notes</source>
   <translation>Notizen</translation>
  </message>
  <message>
   <source>The sample, where it is from, who photographed it and when…</source>
   <translation>Die Probe, ihre Herkunft, wer sie wann fotografiert hat …</translation>
  </message>
  <message>
   <source>Libraries</source>
   <translation>Bibliotheken</translation>
  </message>
  <message>
   <source>PySide6 %1, Qt %2, numpy %3</source>
   <translation>PySide6 %1, Qt %2, numpy %3</translation>
  </message>
  <message>
   <source>the beginning</source>
   <translation>der Anfang</translation>
  </message>
  <message>
   <source>undone to</source>
   <translation>zurück bis</translation>
  </message>
  <message>
   <source>cannot be opened in a file manager</source>
   <translation>lässt sich in keinem Dateimanager öffnen</translation>
  </message>
  <message>
   <source>Open it by hand</source>
   <translation>Von Hand öffnen</translation>
  </message>
  <message>
   <source>Something went wrong</source>
   <translation>Etwas ist schiefgegangen</translation>
  </message>
  <message>
   <source>%1.
Your work is still here. %2.</source>
   <translation>%1.
Ihre Arbeit ist noch da. %2.</translation>
  </message>
  <message>
   <source>This is a fault in Lightarc, not in your files. Your work is still here; the log has the details.</source>
   <translation>Das ist ein Fehler in Lightarc, nicht in Ihren Dateien. Ihre Arbeit ist noch da; Einzelheiten stehen im Protokoll.</translation>
  </message>
  <message>
   <source>has a name that is not UTF-8</source>
   <translation>hat einen Namen, der nicht UTF-8 ist</translation>
  </message>
  <message>
   <source>Rename it, or drop it on the window</source>
   <translation>Umbenennen oder auf das Fenster ziehen</translation>
  </message>
  <message>
   <source>The saved project cannot be opened</source>
   <translation>Das gespeicherte Projekt lässt sich nicht öffnen</translation>
  </message>
  <message>
   <source>%1 is not cleaned up: it %2</source>
   <translation>%1 wird nicht aufgeräumt: es %2</translation>
  </message>
  <message>
   <source>cannot be written</source>
   <translation>lässt sich nicht schreiben</translation>
  </message>
  <message>
   <source>There is nothing to clean up in this project yet</source>
   <translation>In diesem Projekt gibt es noch nichts aufzuräumen</translation>
  </message>
  <message>
   <source>Leave</source>
   <translation>Verlassen</translation>
  </message>
  <message>
   <source>One project is open in a window, here %1. Open this one in another window</source>
   <translation>Ein Fenster hat ein Projekt, hier %1. Dieses in einem anderen Fenster öffnen</translation>
  </message>
  <message>
   <source>is a second project</source>
   <translation>ist ein zweites Projekt</translation>
  </message>
  <message>
   <source>Couldn't open "%1"</source>
   <translation>„%1“ lässt sich nicht öffnen</translation>
  </message>
  <message>
   <source>Couldn't open %1 of %2 files</source>
   <translation>%1 von %2 Dateien lassen sich nicht öffnen</translation>
  </message>
  <message>
   <source>Recover</source>
   <translation>Wiederherstellen</translation>
  </message>
  <message>
   <source>%1 recovered%2</source>
   <translation>%1 wiederhergestellt%2</translation>
  </message>
  <message>
   <source>Open</source>
   <translation>Öffnen</translation>
  </message>
  <message>
   <source>Folder of photographs</source>
   <translation>Ordner mit Fotos</translation>
  </message>
  <message>
   <source>Save as</source>
   <translation>Speichern unter</translation>
  </message>
  <message>
   <source>Collect</source>
   <translation>Sammeln</translation>
  </message>
  <message>
   <source>The project cannot be written</source>
   <translation>Das Projekt lässt sich nicht schreiben</translation>
  </message>
  <message>
   <source>Lightarc ended unexpectedly in the middle of this work: %1.</source>
   <translation>Lightarc wurde mitten in dieser Arbeit unerwartet beendet: %1.</translation>
  </message>
  <message>
   <source>%1 %2 is as you left it%3.</source>
   <translation>%1: %2 ist so, wie Sie es verlassen haben%3.</translation>
  </message>
  <message>
   <source>Lightarc ended unexpectedly.</source>
   <translation>Lightarc wurde unerwartet beendet.</translation>
  </message>
  <message>
   <source>Resume all</source>
   <translation>Alle fortsetzen</translation>
  </message>
  <message>
   <source>, after “%1”</source>
   <translation>, nach „%1“</translation>
  </message>
  <message>
   <source>Quit</source>
   <translation>Beenden</translation>
  </message>
  <message>
   <source>Lightarc quits when this has ended:</source>
   <translation>Lightarc wird beendet, sobald dies fertig ist:</translation>
  </message>
  <message>
   <source>This project closes when this has ended:</source>
   <translation>Dieses Projekt wird geschlossen, sobald dies fertig ist:</translation>
  </message>
  <message>
   <source>Still running</source>
   <translation>Läuft noch</translation>
  </message>
  <message>
   <source>%1 without saving</source>
   <translation>%1 ohne zu speichern</translation>
  </message>
  <message>
   <source>and %1 more</source>
   <translation>und %1 weitere</translation>
  </message>
  <message>
   <source>%1 and stop %2</source>
   <translation>%1 und %2 abbrechen</translation>
  </message>
  <message>
   <source>Saving…</source>
   <translation>Wird gespeichert…</translation>
  </message>
  <message>
   <source>Lightarc uses this number of CPUs from its next start on</source>
   <translation>Lightarc verwendet diese Zahl von CPUs ab dem nächsten Start</translation>
  </message>
  <message>
   <source>Lightarc uses this language from its next start on</source>
   <translation>Lightarc verwendet diese Sprache ab dem nächsten Start</translation>
  </message>
  <message>
   <source>Lightarc uses this graphics device from its next start on</source>
   <translation>Lightarc verwendet dieses Grafikgerät ab dem nächsten Start</translation>
  </message>
  <message>
   <source>The sphere</source>
   <translation>Die Kugel</translation>
  </message>
  <message>
   <source>The preview</source>
   <translation>Die Vorschau</translation>
  </message>
  <message>
   <source>Lightarc crashed the last time. A report says where; please send it to the developers.</source>
   <translation>Lightarc ist beim letzten Mal abgestürzt. Ein Bericht nennt die Stelle; bitte an die Entwickler senden.</translation>
  </message>
  <message>
   <source>Couldn't %1 "%2"</source>
   <translation>Fehlgeschlagen: %1 „%2“</translation>
  </message>
  <message>
   <source>%1 failed</source>
   <translation>%1: fehlgeschlagen</translation>
  </message>
  <message>
   <source>%1 cannot be drawn</source>
   <translation>%1 lässt sich nicht zeichnen</translation>
  </message>
  <message>
   <source>This step cannot be read now</source>
   <translation>Dieser Schritt lässt sich jetzt nicht lesen</translation>
  </message>
  <message>
   <source>The model cannot be drawn</source>
   <translation>Das Modell lässt sich nicht zeichnen</translation>
  </message>
  <message>
   <source>Show the report</source>
   <translation>Bericht zeigen</translation>
  </message>
  <message>
   <source>Crash reports are in %1</source>
   <translation>Absturzberichte liegen in %1</translation>
  </message>
  <message>
   <source>The crash reports cannot be shown</source>
   <translation>Die Absturzberichte lassen sich nicht zeigen</translation>
  </message>
  <message>
   <source>not saved</source>
   <translation>nicht gespeichert</translation>
  </message>
  <message>
   <source>%1 – Lightarc</source>
   <translation>%1 – Lightarc</translation>
  </message>
  <message>
   <source>Save elsewhere…</source>
   <translation>Woanders speichern…</translation>
  </message>
  <message>
   <source>%1 is not saved: %2. All changes stay in memory until they can be written.</source>
   <translation>%1 ist nicht gespeichert: %2. Alle Änderungen bleiben im Speicher, bis sie sich schreiben lassen.</translation>
  </message>
  <message>
   <source>%1 is saved. This window goes on in it when “%2” has ended.</source>
   <translation>%1 ist gespeichert. Dieses Fenster wechselt dorthin, sobald „%2“ fertig ist.</translation>
  </message>
  <message>
   <source>Stop that and go on now</source>
   <translation>Abbrechen und jetzt wechseln</translation>
  </message>
  <message>
   <source>%1 %2. Changes in this window are not kept in it.</source>
   <translation>%1 %2. Änderungen in diesem Fenster werden darin nicht gespeichert.</translation>
  </message>
  <message>
   <source>&amp;File</source>
   <translation>&amp;Datei</translation>
  </message>
  <message>
   <source>&amp;Edit</source>
   <translation>&amp;Bearbeiten</translation>
  </message>
  <message>
   <source>&amp;View</source>
   <translation>&amp;Ansicht</translation>
  </message>
  <message>
   <source>&amp;Help</source>
   <translation>&amp;Hilfe</translation>
  </message>
  <message>
   <source>Projects…</source>
   <translation>Projekte…</translation>
  </message>
  <message>
   <source>Open project…</source>
   <translation>Projekt öffnen…</translation>
  </message>
  <message>
   <source>Save</source>
   <translation>Speichern</translation>
  </message>
  <message>
   <source>Collect…</source>
   <translation>Sammeln…</translation>
  </message>
  <message>
   <source>Notes…</source>
   <translation>Notizen…</translation>
  </message>
  <message>
   <source>Close project</source>
   <translation>Projekt schließen</translation>
  </message>
  <message>
   <source>Close and clean up</source>
   <translation>Schließen und aufräumen</translation>
  </message>
  <message>
   <source>Remove what can be made again from the photographs; it is made again when the project is opened</source>
   <translation>Entfernen, was sich aus den Fotos neu erzeugen lässt; es wird beim Öffnen des Projekts neu erzeugt</translation>
  </message>
  <message>
   <source>Open files…</source>
   <translation>Dateien öffnen…</translation>
  </message>
  <message>
   <source>Open folder…</source>
   <translation>Ordner öffnen…</translation>
  </message>
  <message>
   <source>Open recent</source>
   <translation>Zuletzt geöffnet</translation>
  </message>
  <message>
   <source>Sample capture</source>
   <translation>Beispielaufnahme</translation>
  </message>
  <message>
   <source>Open a woven cloth, ready-made, in a project of its own</source>
   <translation>Ein gewebtes Tuch öffnen, fertig vorbereitet, in einem eigenen Projekt</translation>
  </message>
  <message>
   <source>Rebuild sample</source>
   <translation>Beispiel neu erzeugen</translation>
  </message>
  <message>
   <source>Simulate the photographs of a woven cloth at full size, import them and build the material</source>
   <translation>Fotos eines gewebten Tuchs in voller Größe simulieren, importieren und das Material erzeugen</translation>
  </message>
  <message>
   <source>Watch…</source>
   <translation>Mitverfolgen…</translation>
  </message>
  <message>
   <source>Take photographs in while a camera writes them, and import them when all are there</source>
   <translation>Fotos aufnehmen, während eine Kamera sie schreibt, und importieren, sobald alle da sind</translation>
  </message>
  <message>
   <source>Batch…</source>
   <translation>Stapel…</translation>
  </message>
  <message>
   <source>Make materials, projects and exports of many captures in one run</source>
   <translation>Aus vielen Aufnahmen in einem Lauf Materialien, Projekte und Exporte machen</translation>
  </message>
  <message>
   <source>Save image…</source>
   <translation>Bild speichern…</translation>
  </message>
  <message>
   <source>Save turntable…</source>
   <translation>Drehung speichern…</translation>
  </message>
  <message>
   <source>Export bundle…</source>
   <translation>Paket exportieren…</translation>
  </message>
  <message>
   <source>Undo</source>
   <translation>Rückgängig</translation>
  </message>
  <message>
   <source>Redo</source>
   <translation>Wiederholen</translation>
  </message>
  <message>
   <source>History…</source>
   <translation>Verlauf…</translation>
  </message>
  <message>
   <source>Preferences…</source>
   <translation>Einstellungen…</translation>
  </message>
  <message>
   <source>Dark theme</source>
   <translation>Dunkles Design</translation>
  </message>
  <message>
   <source>Light theme</source>
   <translation>Helles Design</translation>
  </message>
  <message>
   <source>Error of the image</source>
   <translation>Fehler des Bildes</translation>
  </message>
  <message>
   <source>Compare the image of the View workspace with a reference, while no other job runs</source>
   <translation>Das Bild des Arbeitsbereichs Ansicht mit einer Referenz vergleichen, solange kein anderer Auftrag läuft</translation>
  </message>
  <message>
   <source>Help for this panel</source>
   <translation>Hilfe zu diesem Bereich</translation>
  </message>
  <message>
   <source>Mouse and keyboard</source>
   <translation>Maus und Tastatur</translation>
  </message>
  <message>
   <source>Which mode when…</source>
   <translation>Welcher Modus wann…</translation>
  </message>
  <message>
   <source>Welcome tour</source>
   <translation>Einführung</translation>
  </message>
  <message>
   <source>Crash reports…</source>
   <translation>Absturzberichte…</translation>
  </message>
  <message>
   <source>About Lightarc</source>
   <translation>Über Lightarc</translation>
  </message>
  <message>
   <source>This project has no name yet. Save it to choose where it lives.</source>
   <translation>Dieses Projekt hat noch keinen Namen. Beim Speichern wird sein Ort gewählt.</translation>
  </message>
  <message>
   <source>Save as %1…</source>
   <translation>%1 speichern unter…</translation>
  </message>
  <message>
   <source>Later</source>
   <translation>Später</translation>
  </message>
  <message>
   <source>System default</source>
   <translation>Wie das System</translation>
  </message>
  <message>
   <source>Dark</source>
   <translation>Dunkel</translation>
  </message>
  <message>
   <source>Millimetres</source>
   <translation>Millimeter</translation>
  </message>
  <message>
   <source>Centimetres</source>
   <translation>Zentimeter</translation>
  </message>
  <message>
   <source>Inches</source>
   <translation>Zoll</translation>
  </message>
  <message>
   <source>By language</source>
   <translation>Wie die Sprache</translation>
  </message>
  <message>
   <source>Preferences</source>
   <translation>Einstellungen</translation>
  </message>
  <message>
   <source>Window</source>
   <translation>Fenster</translation>
  </message>
  <message>
   <source>Theme</source>
   <translation>Design</translation>
  </message>
  <message>
   <source>Language</source>
   <translation>Sprache</translation>
  </message>
  <message>
   <source>Language of the window, from the next start on</source>
   <translation>Sprache des Fensters, ab dem nächsten Start</translation>
  </message>
  <message>
   <source>Numbers</source>
   <translation>Zahlen</translation>
  </message>
  <message>
   <source>The decimal mark of figures and fields</source>
   <translation>Das Dezimalzeichen von Werten und Feldern</translation>
  </message>
  <message>
   <source>Of new projects; View &gt; Image has this one's</source>
   <translation>Für neue Projekte; für dieses unter Ansicht &gt; Bild</translation>
  </message>
  <message>
   <source>Lengths</source>
   <translation>Längen</translation>
  </message>
  <message>
   <source>Unit of the width of a sample</source>
   <translation>Einheit der Breite einer Probe</translation>
  </message>
  <message>
   <source>Machine</source>
   <translation>Rechner</translation>
  </message>
  <message>
   <source>Second graphics card</source>
   <translation>Zweite Grafikkarte</translation>
  </message>
  <message>
   <source>As the system chooses</source>
   <translation>Wie das System wählt</translation>
  </message>
  <message>
   <source>The CPU alone</source>
   <translation>Nur die CPU</translation>
  </message>
  <message>
   <source>; now %1</source>
   <translation>; jetzt %1</translation>
  </message>
  <message>
   <source>What draws the images, from the next start on%1</source>
   <translation>Was die Bilder zeichnet, ab dem nächsten Start%1</translation>
  </message>
  <message>
   <source>Graphics</source>
   <translation>Grafik</translation>
  </message>
  <message>
   <source>CPUs that the program uses, from its next start on</source>
   <translation>CPUs, die das Programm verwendet, ab dem nächsten Start</translation>
  </message>
  <message>
   <source>CPUs</source>
   <translation>CPUs</translation>
  </message>
  <message>
   <source>All %1</source>
   <translation>Alle %1</translation>
  </message>
  <message>
   <source>%1 GB</source>
   <translation>%1 GB</translation>
  </message>
  <message>
   <source>50 % of free memory</source>
   <translation>50 % des freien Speichers</translation>
  </message>
  <message>
   <source>The most that a setting may take which a plan chooses</source>
   <translation>Höchstwert für eine Einstellung, die ein Plan wählt</translation>
  </message>
  <message>
   <source>Memory</source>
   <translation>Speicher</translation>
  </message>
  <message>
   <source>Cache</source>
   <translation>Cache</translation>
  </message>
  <message>
   <source>Clear</source>
   <translation>Leeren</translation>
  </message>
  <message>
   <source>Working copies of results, costs measured on this machine and the ready-made sample. All are made again when needed; results whose photographs are gone stay</source>
   <translation>Arbeitskopien von Ergebnissen, auf diesem Rechner gemessene Kosten und das vorbereitete Beispiel. Alles wird bei Bedarf neu erzeugt; Ergebnisse ohne ihre Fotos bleiben</translation>
  </message>
  <message>
   <source>The most that working copies of results take; automatic is 10 GB, or half of what the disk has left</source>
   <translation>Höchstwert für Arbeitskopien von Ergebnissen; automatisch sind 10 GB oder die Hälfte des freien Platzes</translation>
  </message>
  <message>
   <source>Limit</source>
   <translation>Grenze</translation>
  </message>
  <message>
   <source>Keeping the cache within its limit</source>
   <translation>Cache wird innerhalb seiner Grenze gehalten</translation>
  </message>
  <message>
   <source>Measuring the cache</source>
   <translation>Cache wird gemessen</translation>
  </message>
  <message>
   <source>It is empty</source>
   <translation>Er ist leer</translation>
  </message>
  <message>
   <source>It is being emptied</source>
   <translation>Er wird geleert</translation>
  </message>
  <message>
   <source>Emptying the cache</source>
   <translation>Cache wird geleert</translation>
  </message>
  <message>
   <source>Opening the project</source>
   <translation>Projekt wird geöffnet</translation>
  </message>
  <message>
   <source>%1 is open. %2</source>
   <translation>%1 ist geöffnet. %2</translation>
  </message>
  <message>
   <source>Not saved: %1</source>
   <translation>Nicht gespeichert: %1</translation>
  </message>
  <message>
   <source>Saving as %1</source>
   <translation>Wird gespeichert als %1</translation>
  </message>
  <message>
   <source>Saved as %1 %2</source>
   <translation>Gespeichert als %1 %2</translation>
  </message>
  <message>
   <source>does not hold the latest changes</source>
   <translation>enthält die letzten Änderungen nicht</translation>
  </message>
  <message>
   <source>Save the project elsewhere first</source>
   <translation>Das Projekt zuerst woanders speichern</translation>
  </message>
  <message>
   <source>Collecting %1</source>
   <translation>%1 wird gesammelt</translation>
  </message>
  <message>
   <source>%1 holds the project and all that it needs</source>
   <translation>%1 enthält das Projekt und alles, was es braucht</translation>
  </message>
  <message>
   <source>Recovering %1</source>
   <translation>%1 wird wiederhergestellt</translation>
  </message>
  <message>
   <source>; and %1 more</source>
   <translation>; und %1 weitere</translation>
  </message>
  <message>
   <source>%1 holds what was sound. Lost: %2</source>
   <translation>%1 enthält, was unbeschädigt war. Verloren: %2</translation>
  </message>
  <message>
   <source>%1 is whole</source>
   <translation>%1 ist vollständig</translation>
  </message>
  <message>
   <source>%1 had been removed, and was written again</source>
   <translation>%1 war entfernt worden und wurde neu geschrieben</translation>
  </message>
  <message>
   <source>Saved %1</source>
   <translation>%1 gespeichert</translation>
  </message>
  <message>
   <source>opening %1</source>
   <translation>%1 wird geöffnet</translation>
  </message>
  <message>
   <source>What was made from the sources is gone, and can be made again</source>
   <translation>Was aus den Quellen erzeugt wurde, fehlt und lässt sich neu erzeugen</translation>
  </message>
  <message>
   <source>writing the project that was open</source>
   <translation>das geöffnete Projekt wird geschrieben</translation>
  </message>
  <message>
   <source>writing the latest changes</source>
   <translation>die letzten Änderungen werden geschrieben</translation>
  </message>
  <message>
   <source>cannot be written now</source>
   <translation>lässt sich jetzt nicht schreiben</translation>
  </message>
  <message>
   <source>Check the disk that it lies on</source>
   <translation>Den Datenträger prüfen, auf dem es liegt</translation>
  </message>
  <message>
   <source>is open in another window</source>
   <translation>ist in einem anderen Fenster geöffnet</translation>
  </message>
  <message>
   <source>%1 (missing)</source>
   <translation>%1 (fehlt)</translation>
  </message>
  <message>
   <source>Nothing yet</source>
   <translation>Noch nichts</translation>
  </message>
  <message>
   <source>Making a small image</source>
   <translation>Kleines Bild wird erzeugt</translation>
  </message>
  <message>
   <source>Rebuilding the material</source>
   <translation>Material wird neu erzeugt</translation>
  </message>
  <message>
   <source>Reading the photographs again</source>
   <translation>Fotos werden neu gelesen</translation>
  </message>
  <message>
   <source>Rebuilding surface maps</source>
   <translation>Oberflächenkarten werden neu erzeugt</translation>
  </message>
  <message>
   <source>looking for the photographs</source>
   <translation>Fotos werden gesucht</translation>
  </message>
  <message>
   <source>BRDF or material</source>
   <translation>BRDF oder Material</translation>
  </message>
  <message>
   <source>Model and environment</source>
   <translation>Modell und Umgebung</translation>
  </message>
  <message>
   <source>%1 (Ctrl+%2)</source>
   <translation>%1 (Strg+%2)</translation>
  </message>
  <message>
   <source>Looking for the photographs</source>
   <translation>Fotos werden gesucht</translation>
  </message>
  <message>
   <source>Looking at the images</source>
   <translation>Bilder werden untersucht</translation>
  </message>
  <message>
   <source>%1 missing%2.</source>
   <translation>%1 fehlt%2.</translation>
  </message>
  <message>
   <source>Find…</source>
   <translation>Suchen…</translation>
  </message>
  <message>
   <source>%1. Nothing was made again.</source>
   <translation>%1. Nichts wurde neu erzeugt.</translation>
  </message>
  <message>
   <source>Folder that the photographs moved to</source>
   <translation>Ordner, in dem die Fotos jetzt liegen</translation>
  </message>
  <message>
   <source>Finding the photographs</source>
   <translation>Fotos werden gesucht</translation>
  </message>
  <message>
   <source>%1 of %2 photographs found</source>
   <translation>%1 von %2 Fotos gefunden</translation>
  </message>
  <message>
   <source>All photographs found</source>
   <translation>Alle Fotos gefunden</translation>
  </message>
  <message>
   <source>. What was made of %1 is here</source>
   <translation>. Was aus %1 erzeugt wurde, ist da</translation>
  </message>
  <message>
   <source>. The material made of %1 is here</source>
   <translation>. Das aus %1 erzeugte Material ist da</translation>
  </message>
  <message>
   <source>, and what was made of %1 as well</source>
   <translation>, und was aus %1 erzeugt wurde, ebenfalls</translation>
  </message>
  <message>
   <source>looking through the folder</source>
   <translation>Ordner wird durchsucht</translation>
  </message>
  <message>
   <source>This project is read-only; save it under another name first</source>
   <translation>Dieses Projekt ist schreibgeschützt; zuerst unter einem anderen Namen speichern</translation>
  </message>
 </context>
 <context>
  <name>start</name>
  <message>
   <source>Woven cloth</source>
   <translation>Gewebtes Tuch</translation>
  </message>
  <message>
   <source>Ten photographs under a light arc</source>
   <translation>Zehn Fotos unter einem Lichtbogen</translation>
  </message>
  <message>
   <source>Bronze medal</source>
   <translation>Bronzemedaille</translation>
  </message>
  <message>
   <source>Forty photographs in a light dome</source>
   <translation>Vierzig Fotos in einer Lichtkuppel</translation>
  </message>
  <message>
   <source>Measured satin</source>
   <translation>Gemessener Satin</translation>
  </message>
  <message>
   <source>A measured BRDF, factored into textures</source>
   <translation>Gemessene BRDF, in Texturen zerlegt</translation>
  </message>
  <message>
   <source>A material or an object under a moving light</source>
   <translation>Ein Material oder Objekt unter bewegtem Licht</translation>
  </message>
  <message>
   <source>Measured BRDFs, PBR textures, MaterialX, a bundle</source>
   <translation>BRDFs, PBR-Texturen, MaterialX, Pakete</translation>
  </message>
  <message>
   <source>A mesh and an HDR environment that lights it</source>
   <translation>Ein Netz und eine HDR-Umgebung, die es beleuchtet</translation>
  </message>
  <message>
   <source>reading the list of projects</source>
   <translation>Liste der Projekte wird gelesen</translation>
  </message>
  <message>
   <source>reading thumbnails</source>
   <translation>Vorschaubilder werden gelesen</translation>
  </message>
  <message>
   <source>Start page</source>
   <translation>Startseite</translation>
  </message>
  <message>
   <source>Examples</source>
   <translation>Beispiele</translation>
  </message>
  <message>
   <source>Start with</source>
   <translation>Beginnen mit</translation>
  </message>
  <message>
   <source>Search projects</source>
   <translation>Projekte suchen</translation>
  </message>
  <message>
   <source>Projects</source>
   <translation>Projekte</translation>
  </message>
  <message>
   <source>Rename…</source>
   <translation>Umbenennen…</translation>
  </message>
  <message>
   <source>Give the project another name in its folder (F2)</source>
   <translation>Dem Projekt in seinem Ordner einen anderen Namen geben (F2)</translation>
  </message>
  <message>
   <source>Show in folder</source>
   <translation>Im Ordner zeigen</translation>
  </message>
  <message>
   <source>Open the folder of the project file</source>
   <translation>Den Ordner der Projektdatei öffnen</translation>
  </message>
  <message>
   <source>Clean up</source>
   <translation>Aufräumen</translation>
  </message>
  <message>
   <source>Remove what can be made again; a project that is open here is closed</source>
   <translation>Entfernen, was sich neu erzeugen lässt; ein hier geöffnetes Projekt wird geschlossen</translation>
  </message>
  <message>
   <source>Move to trash</source>
   <translation>In den Papierkorb</translation>
  </message>
  <message>
   <source>Move the project and its data to the trash of the system (Delete)</source>
   <translation>Das Projekt und seine Daten in den Papierkorb des Systems legen (Entf)</translation>
  </message>
  <message>
   <source>No project fits this search.</source>
   <translation>Kein Projekt passt zu dieser Suche.</translation>
  </message>
  <message>
   <source>Reading the list of projects</source>
   <translation>Liste der Projekte wird gelesen</translation>
  </message>
  <message>
   <source>%1 project%2</source>
   <translation>%1 Projekt</translation>
  </message>
  <message>
   <source>Choose a project first</source>
   <translation>Zuerst ein Projekt wählen</translation>
  </message>
  <message>
   <source>This project is open in this window</source>
   <translation>Dieses Projekt ist in diesem Fenster geöffnet</translation>
  </message>
  <message>
   <source>This project is open in another window</source>
   <translation>Dieses Projekt ist in einem anderen Fenster geöffnet</translation>
  </message>
  <message>
   <source>Rename project</source>
   <translation>Projekt umbenennen</translation>
  </message>
  <message>
   <source>Name of the project</source>
   <translation>Name des Projekts</translation>
  </message>
  <message>
   <source>Renaming %1</source>
   <translation>%1 wird umbenannt</translation>
  </message>
  <message>
   <source>The project is %1</source>
   <translation>Das Projekt heißt %1</translation>
  </message>
  <message>
   <source>Moving %1 to the trash</source>
   <translation>%1 kommt in den Papierkorb</translation>
  </message>
  <message>
   <source>%1 is in the trash of the system</source>
   <translation>%1 ist im Papierkorb des Systems</translation>
  </message>
  <message>
   <source>Cleaning up %1</source>
   <translation>%1 wird aufgeräumt</translation>
  </message>
  <message>
   <source>%1: %2 freed</source>
   <translation>%1: %2 freigegeben</translation>
  </message>
  <message>
   <source>Opening…</source>
   <translation>Wird geöffnet…</translation>
  </message>
  <message>
   <source>Not saved under a name yet</source>
   <translation>Noch ohne Namen</translation>
  </message>
  <message>
   <source>%1 · open in another window</source>
   <translation>%1 · in einem anderen Fenster geöffnet</translation>
  </message>
  <message>
   <source>Today</source>
   <translation>Heute</translation>
  </message>
  <message>
   <source>Yesterday</source>
   <translation>Gestern</translation>
  </message>
 </context>
 <context>
  <name>help</name>
  <message>
   <source>Mouse in the viewport
Left-drag	rotate the model
Middle-drag	move
Wheel	zoom
Ctrl+left-drag	move the light, rotate the environment
Arrow keys	rotate the model (Ctrl: move the light, rotate the environment); + and - zoom
Shift or Alt+arrow keys	move the model, move the line between both modes
F	frame the model, fit the image
H, W, G	baked light: SH, wavelet, Gaussian
Ctrl+Enter	bake, or stop baking
M, D, R	shading map, direct light, reference
Tab	swap the two modes while both are shown
Ctrl+P	save an image (Ctrl+Shift+P: a turntable)
B, E	both modes separated by a line, their difference

Photographs and materials
Ctrl+Enter	import again with changed settings, build the material, make surface maps

Images
Wheel	zoom under the pointer
1	100 %
Left, Right	previous, next photograph
X, Space	leave the selected photographs out, or use them again
Ctrl+A, Shift+Up	select all, select several
Z	loupe at 100 % (drag it or press arrow keys; the wheel, + and - magnify)
M	mark clipped texels
Arrow keys	move the chosen point or reflection (Ctrl: finer, Shift: farther)
Ins, Del	add, delete a point; Esc leaves
Left, Right, Space	previous, next lamp of the dome, select it

BRDFs
Enter	add the chosen BRDF of the library
Space, Del	show or hide, remove an entry of the list
Ctrl+left-drag	move the light of the lobes
L	logarithmic or linear
Ctrl+F, Esc	search the library, show all views

Factors
Ctrl+Enter	begin a run
Click a point	preview and export that number of terms
Space, Del	pause or go on with, remove a run of the list
Left, Right	fewer, more terms while on the textures

Export
Ctrl+Enter	write the bundle, or the chosen targets

Numbers
Drag a field	change it
Type	a number, a unit, or 2*3.5
Enter, Esc	take what is typed, or the value from before, and return to the work area
Ctrl+click	reset</source>
   <translation>Maus im Ansichtsfenster
Links ziehen	Modell drehen
Mitte ziehen	verschieben
Mausrad	zoomen
Strg+links ziehen	Licht bewegen, Umgebung drehen
Pfeiltasten	Modell drehen (Strg: Licht bewegen, Umgebung drehen); + und - zoomen
Umschalt oder Alt+Pfeiltasten	das Modell verschieben, die Linie zwischen beiden Modi verschieben
F	Modell oder Bild einpassen
H, W, G	vorberechnetes Licht: SH, Wavelet, Gauß
Strg+Eingabe	vorberechnen oder die Vorberechnung beenden
M, D, R	Schattierungskarte, direktes Licht, Referenz
Tab	die beiden Modi vertauschen, solange beide gezeigt werden
Strg+P	Bild speichern (Strg+Umschalt+P: Drehung)
B, E	beide Modi mit Trennlinie, ihr Unterschied

Fotos und Materialien
Strg+Eingabe	mit geänderten Einstellungen neu importieren, Material erzeugen, Oberflächenkarten erzeugen

Bilder
Mausrad	unter dem Zeiger zoomen
1	100 %
Links, Rechts	vorheriges, nächstes Foto
X, Leertaste	ausgewählte Fotos ausschließen oder wieder verwenden
Strg+A, Umschalt+Auf	alle, mehrere auswählen
Z	Lupe bei 100 % (ziehen oder Pfeiltasten; Mausrad, + und - vergrößern)
M	übersteuerte Texel markieren
Pfeiltasten	gewählten Punkt oder Spiegelbild bewegen (Strg: feiner, Umschalt: weiter)
Einfg, Entf	Punkt hinzufügen, löschen; Esc verlässt die Ansicht
Links, Rechts, Leertaste	vorherige, nächste Lampe der Kuppel, auswählen

BRDFs
Eingabe	gewählte BRDF der Bibliothek hinzufügen
Leertaste, Entf	Eintrag der Liste zeigen oder verbergen, entfernen
Strg+links ziehen	Licht der Keulen bewegen
L	logarithmisch oder linear
Strg+F, Esc	Bibliothek durchsuchen, alle Ansichten zeigen

Faktoren
Strg+Eingabe	Lauf beginnen
Punkt anklicken	diese Zahl von Termen zeigen und exportieren
Leertaste, Entf	Lauf der Liste anhalten oder fortsetzen, entfernen
Links, Rechts	weniger, mehr Terme, solange die Texturen den Fokus haben

Export
Strg+Eingabe	Paket oder gewählte Ziele schreiben

Zahlen
Feld ziehen	ändern
Tippen	Zahl, Einheit oder 2*3,5
Eingabe, Esc	Eingabe oder vorigen Wert übernehmen und zur Arbeitsfläche zurückkehren
Strg+Klick	zurücksetzen</translation>
  </message>
  <message>
   <source>Lightarc %1</source>
   <translation>Lightarc %1</translation>
  </message>
  <message>
   <source>Ten photographs of a material under a moving lamp become a material.
MIT licence.</source>
   <translation>Zehn Fotos eines Materials unter einer bewegten Lampe werden zu einem Material.
MIT-Lizenz.</translation>
  </message>
  <message>
   <source>Third-party licences</source>
   <translation>Lizenzen Dritter</translation>
  </message>
  <message>
   <source>Manual</source>
   <translation>Handbuch</translation>
  </message>
  <message>
   <source>Previous page</source>
   <translation>Vorige Seite</translation>
  </message>
  <message>
   <source>Frame</source>
   <translation>Bild</translation>
  </message>
  <message>
   <source>Which mode when</source>
   <translation>Welcher Modus wann</translation>
  </message>
  <message>
   <source>Modes</source>
   <translation>Modi</translation>
  </message>
  <message>
   <source>Measure all modes</source>
   <translation>Alle Modi messen</translation>
  </message>
  <message>
   <source>Draw with every mode and compare with the reference</source>
   <translation>Mit jedem Modus zeichnen und mit der Referenz vergleichen</translation>
  </message>
  <message>
   <source>Use this mode</source>
   <translation>Diesen Modus verwenden</translation>
  </message>
  <message>
   <source>Measured on %1: of each mode the setting with the least error.</source>
   <translation>Gemessen an %1: von jedem Modus die Einstellung mit dem kleinsten Fehler.</translation>
  </message>
  <message>
   <source>Nothing was measured on this scene yet.</source>
   <translation>An dieser Szene wurde noch nichts gemessen.</translation>
  </message>
  <message>
   <source>Previous</source>
   <translation>Zurück</translation>
  </message>
  <message>
   <source>Next</source>
   <translation>Weiter</translation>
  </message>
  <message>
   <source>End</source>
   <translation>Ende</translation>
  </message>
  <message>
   <source>The material on a model</source>
   <translation>Das Material auf einem Modell</translation>
  </message>
  <message>
   <source>Drag rotates, the wheel zooms, Ctrl+drag moves the light. Try it now: the tour waits.</source>
   <translation>Ziehen dreht, das Mausrad zoomt, Strg+Ziehen bewegt das Licht. Jetzt ausprobieren: die Einführung wartet.</translation>
  </message>
  <message>
   <source>Built-in models, or a mesh of your own: File &gt; Open files.</source>
   <translation>Eingebaute Modelle oder ein eigenes Netz: Datei &gt; Dateien öffnen.</translation>
  </message>
  <message>
   <source>Direction and strength of the light, more lights, or an HDR.</source>
   <translation>Richtung und Stärke des Lichts, weitere Lichter oder ein HDR.</translation>
  </message>
  <message>
   <source>Each mode trades accuracy for time. Help &gt; Which mode when shows what was measured on your machine.</source>
   <translation>Jeder Modus tauscht Genauigkeit gegen Zeit. Hilfe &gt; Welcher Modus wann zeigt, was auf Ihrem Rechner gemessen wurde.</translation>
  </message>
  <message>
   <source>The error is always stated</source>
   <translation>Der Fehler wird immer genannt</translation>
  </message>
  <message>
   <source>What is on screen is compared with a reference in the background; its error is shown here.</source>
   <translation>Das Bild wird im Hintergrund mit einer Referenz verglichen; sein Fehler steht hier.</translation>
  </message>
  <message>
   <source>Hand it on</source>
   <translation>Weitergeben</translation>
  </message>
  <message>
   <source>Capture to Export follow the work. Export writes the material for other programs. F1 explains each panel.</source>
   <translation>Aufnahme bis Export folgen der Arbeit. Export schreibt das Material für andere Programme. F1 erklärt jeden Bereich.</translation>
  </message>
 </context>
 <context>
  <name>document</name>
  <message>
   <source>at most %1 BRDFs are compared</source>
   <translation>höchstens %1 BRDFs werden verglichen</translation>
  </message>
  <message>
   <source>Strength of the light.</source>
   <translation>Stärke des Lichts.</translation>
  </message>
  <message>
   <source>Strength of the environment.</source>
   <translation>Stärke der Umgebung.</translation>
  </message>
  <message>
   <source>Brightness of the image.</source>
   <translation>Helligkeit des Bildes.</translation>
  </message>
  <message>
   <source>Albedo of the ground.</source>
   <translation>Albedo des Bodens.</translation>
  </message>
  <message>
   <source>Untitled</source>
   <translation>Ohne Namen</translation>
  </message>
  <message>
   <source>Models: symmetric or singular values. Measurements: these or a search, by the error in held-out regions</source>
   <translation>Modelle: symmetrisch oder Singulärwerte. Messungen: diese oder eine Suche, nach dem Fehler in zurückgehaltenen Bereichen</translation>
  </message>
  <message>
   <source>Eigenvectors: light and view maps are the same up to their sign (Wang, Tran and Luebke 2004)</source>
   <translation>Eigenvektoren: Licht- und Blickkarten sind bis auf ihr Vorzeichen gleich (Wang, Tran und Luebke 2004)</translation>
  </message>
  <message>
   <source>Singular vectors, for any BRDF</source>
   <translation>Singulärvektoren, für jede BRDF</translation>
  </message>
  <message>
   <source>The same by block power iteration, as published</source>
   <translation>Dasselbe durch Block-Potenzmethode, wie veröffentlicht</translation>
  </message>
  <message>
   <source>Sums without a negative term, which are never black and nearer to dark values (Lee and Seung 1999)</source>
   <translation>Summen ohne negativen Term, nie schwarz und näher an dunklen Werten (Lee und Seung 1999)</translation>
  </message>
  <message>
   <source>A product of two positive textures (Kautz and McCool 1999)</source>
   <translation>Ein Produkt zweier positiver Texturen (Kautz und McCool 1999)</translation>
  </message>
  <message>
   <source>Textures of light, half vector and view, solved together (McCool, Ang and Ahmad 2001)</source>
   <translation>Texturen von Licht, Halbvektor und Blick, gemeinsam gelöst (McCool, Ang und Ahmad 2001)</translation>
  </message>
  <message>
   <source>Textures of the best projections for this BRDF (Cole 2002)</source>
   <translation>Texturen der besten Projektionen für diese BRDF (Cole 2002)</translation>
  </message>
  <message>
   <source>RMS, cosine-weighted</source>
   <translation>RMS, kosinusgewichtet</translation>
  </message>
  <message>
   <source>Mean relative (log)</source>
   <translation>Mittlerer relativer (log)</translation>
  </message>
  <message>
   <source>Mean squared relative (log)</source>
   <translation>Mittlerer quadratischer relativer (log)</translation>
  </message>
  <message>
   <source>Largest relative (log)</source>
   <translation>Größter relativer (log)</translation>
  </message>
  <message>
   <source>Mean absolute</source>
   <translation>Mittlerer absoluter</translation>
  </message>
  <message>
   <source>Mean squared</source>
   <translation>Mittlerer quadratischer</translation>
  </message>
  <message>
   <source>Largest absolute</source>
   <translation>Größter absoluter</translation>
  </message>
  <message>
   <source>Held out: RMS, cosine-weighted</source>
   <translation>Validierung: RMS, kosinusgewichtet</translation>
  </message>
  <message>
   <source>Held out: mean squared relative (log)</source>
   <translation>Validierung: mittlerer quadratischer relativer (log)</translation>
  </message>
  <message>
   <source>RMS × cos</source>
   <translation>RMS × cos</translation>
  </message>
  <message>
   <source>Mean log</source>
   <translation>Mittel log</translation>
  </message>
  <message>
   <source>Mean log²</source>
   <translation>Mittel log²</translation>
  </message>
  <message>
   <source>Max. log</source>
   <translation>Max. log</translation>
  </message>
  <message>
   <source>Mean²</source>
   <translation>Mittel²</translation>
  </message>
  <message>
   <source>Maximum</source>
   <translation>Maximum</translation>
  </message>
  <message>
   <source>Held out: RMS × cos</source>
   <translation>Validierung: RMS × cos</translation>
  </message>
  <message>
   <source>Held out: log²</source>
   <translation>Validierung: log²</translation>
  </message>
  <message>
   <source>a project does not keep this choice of an import: %1; write a stack instead</source>
   <translation>ein Projekt behält diese Wahl eines Imports nicht: %1; stattdessen einen Stapel schreiben</translation>
  </message>
  <message>
   <source>cannot be taken out of so few photographs</source>
   <translation>kann nicht ausgeschlossen werden: es bleiben zu wenige Fotos</translation>
  </message>
  <message>
   <source>At least two under different lights stay</source>
   <translation>Mindestens zwei unter verschiedenem Licht behalten</translation>
  </message>
  <message>
   <source>has the name of another photograph of the capture</source>
   <translation>hat den Namen eines anderen Fotos der Aufnahme</translation>
  </message>
  <message>
   <source>Give it a name of its own</source>
   <translation>Einen eigenen Namen geben</translation>
  </message>
  <message>
   <source>Frame / ms</source>
   <translation>Bild / ms</translation>
  </message>
  <message>
   <source>Relighting / ms</source>
   <translation>Neulicht / ms</translation>
  </message>
  <message>
   <source>Bake / s</source>
   <translation>Vorber. / s</translation>
  </message>
  <message>
   <source>Memory / MB</source>
   <translation>Speicher / MB</translation>
  </message>
  <message>
   <source>power law</source>
   <translation>Potenzgesetz</translation>
  </message>
  <message>
   <source>%1, FLIP %2</source>
   <translation>%1, FLIP %2</translation>
  </message>
  <message>
   <source>frame %1, relighting %2</source>
   <translation>Bild %1, Neubeleuchtung %2</translation>
  </message>
  <message>
   <source>bake %1, memory %2</source>
   <translation>Vorberechnung %1, Speicher %2</translation>
  </message>
  <message>
   <source>predicted: %1</source>
   <translation>vorhergesagt: %1</translation>
  </message>
  <message>
   <source>pays off after %1 frame%2 against the reference</source>
   <translation>lohnt sich gegenüber der Referenz nach %1 Bild</translation>
  </message>
  <message>
   <source>A flat image casts no shadows that could be baked: Material shows it</source>
   <translation>Ein flaches Bild wirft keine Schatten, die vorberechnet werden könnten: „Material“ zeigt es</translation>
  </message>
  <message>
   <source>Sampling by outgoing radiance needs all light at once: choose another under Sampling</source>
   <translation>Die Abtastung nach ausgehender Strahldichte braucht alles Licht zugleich: unter „Abtastung“ eine andere wählen</translation>
  </message>
  <message>
   <source>With %1</source>
   <translation>Mit %1</translation>
  </message>
  <message>
   <source>Colours</source>
   <translation>Farben</translation>
  </message>
  <message>
   <source>bakes in %1 show it</source>
   <translation>Vorberechnungen mit %1 zeigen es</translation>
  </message>
  <message>
   <source>this BRDF has no such parameter</source>
   <translation>diese BRDF hat keinen solchen Parameter</translation>
  </message>
  <message>
   <source>%1 leaves out what varies over the model, %2: %3.</source>
   <translation>%1 lässt weg, was über das Modell variiert, %2: %3.</translation>
  </message>
 </context>
 <context>
  <name>commands</name>
  <message>
   <source>Blinn–Phong</source>
   <translation>Blinn–Phong</translation>
  </message>
  <message>
   <source>%1 BRDFs are compared at most; remove one first</source>
   <translation>Höchstens %1 BRDFs werden verglichen; zuerst eine entfernen</translation>
  </message>
  <message>
   <source>Compare %1</source>
   <translation>%1 vergleichen</translation>
  </message>
  <message>
   <source>Find %1</source>
   <translation>%1 suchen</translation>
  </message>
  <message>
   <source>My %1</source>
   <translation>Mein %1</translation>
  </message>
  <message>
   <source>Compiling %1</source>
   <translation>%1 wird kompiliert</translation>
  </message>
  <message>
   <source>Preparing %1</source>
   <translation>%1 wird vorbereitet</translation>
  </message>
  <message>
   <source>Use %1 for the material</source>
   <translation>%1 für das Material verwenden</translation>
  </message>
  <message>
   <source>The material reflects as %1</source>
   <translation>Das Material reflektiert wie %1</translation>
  </message>
  <message>
   <source>; as a table it has an error of %1 RMS</source>
   <translation>; als Tabelle mit einem Fehler von %1 RMS</translation>
  </message>
  <message>
   <source>%1 written%2</source>
   <translation>%1 geschrieben%2</translation>
  </message>
  <message>
   <source>comparing starts</source>
   <translation>Vergleich beginnt</translation>
  </message>
  <message>
   <source>exchanging light and viewer</source>
   <translation>Licht und Blick werden vertauscht</translation>
  </message>
  <message>
   <source>drawing thumbnails</source>
   <translation>Vorschaubilder werden gezeichnet</translation>
  </message>
  <message>
   <source>looking for the model and the light</source>
   <translation>Modell und Licht werden gesucht</translation>
  </message>
  <message>
   <source>The model %1 is not where it was; the material is shown on another</source>
   <translation>Das Modell %1 liegt nicht mehr an seinem Ort; das Material wird auf einem anderen gezeigt</translation>
  </message>
  <message>
   <source>The light %1 is not where it was</source>
   <translation>Das Licht %1 liegt nicht mehr an seinem Ort</translation>
  </message>
  <message>
   <source>opening the bundle</source>
   <translation>Paket wird geöffnet</translation>
  </message>
  <message>
   <source>opening the material</source>
   <translation>Material wird geöffnet</translation>
  </message>
  <message>
   <source>looking for materials</source>
   <translation>Materialien werden gesucht</translation>
  </message>
  <message>
   <source>Preparing a BRDF</source>
   <translation>BRDF wird vorbereitet</translation>
  </message>
  <message>
   <source>as a table: %1 RMS off%2</source>
   <translation>als Tabelle: Abweichung %1 RMS%2</translation>
  </message>
  <message>
   <source>, mean over azimuths</source>
   <translation>, Mittel über Azimute</translation>
  </message>
  <message>
   <source>table: %1 off</source>
   <translation>Tabelle: Abweichung %1</translation>
  </message>
  <message>
   <source>preparing the bundle</source>
   <translation>Paket wird vorbereitet</translation>
  </message>
  <message>
   <source>verifying the bundle</source>
   <translation>Paket wird geprüft</translation>
  </message>
  <message>
   <source>reading the material</source>
   <translation>Material wird gelesen</translation>
  </message>
  <message>
   <source>the surface is measured</source>
   <translation>Oberfläche wird gemessen</translation>
  </message>
  <message>
   <source>measured before</source>
   <translation>bereits gemessen</translation>
  </message>
  <message>
   <source>judging factors</source>
   <translation>Faktoren werden bewertet</translation>
  </message>
  <message>
   <source>writing factors</source>
   <translation>Faktoren werden geschrieben</translation>
  </message>
  <message>
   <source>%1 written: %2 textures</source>
   <translation>%1 geschrieben: %2 Texturen</translation>
  </message>
  <message>
   <source>%1 × %2 pixels are not possible</source>
   <translation>%1 × %2 Pixel sind nicht möglich</translation>
  </message>
  <message>
   <source>An image is a .png or an .exr file</source>
   <translation>Ein Bild ist eine .png- oder .exr-Datei</translation>
  </message>
  <message>
   <source>A film is an .mp4 or .webp file, or a folder of PNG</source>
   <translation>Ein Film ist eine .mp4- oder .webp-Datei oder ein Ordner mit PNG</translation>
  </message>
  <message>
   <source>A film has at most %1 pixels along a side</source>
   <translation>Ein Film hat höchstens %1 Pixel je Seite</translation>
  </message>
  <message>
   <source>An .mp4 has no transparency</source>
   <translation>Ein .mp4 hat keine Transparenz</translation>
  </message>
  <message>
   <source>frame %1 of %2</source>
   <translation>Bild %1 von %2</translation>
  </message>
  <message>
   <source>%1 frames of </source>
   <translation>%1 Bilder mit </translation>
  </message>
  <message>
   <source>%1 saved: %2%3 × %4 pixels</source>
   <translation>%1 gespeichert: %2%3 × %4 Pixel</translation>
  </message>
  <message>
   <source>There is no bake yet: bake this mode first</source>
   <translation>Es gibt noch keine Vorberechnung: diesen Modus zuerst vorberechnen</translation>
  </message>
  <message>
   <source>looking for the stack</source>
   <translation>Stapel wird gesucht</translation>
  </message>
  <message>
   <source>has lost its pixels</source>
   <translation>hat seine Pixel verloren</translation>
  </message>
  <message>
   <source>Open the photographs that it was made of</source>
   <translation>Die Fotos öffnen, aus denen er entstand</translation>
  </message>
  <message>
   <source>reading the photographs again</source>
   <translation>Fotos werden neu gelesen</translation>
  </message>
  <message>
   <source>preparing the import</source>
   <translation>Import wird vorbereitet</translation>
  </message>
  <message>
   <source>looking for the material</source>
   <translation>Material wird gesucht</translation>
  </message>
  <message>
   <source>the stack</source>
   <translation>der Stapel</translation>
  </message>
  <message>
   <source>loading %1</source>
   <translation>%1 wird geladen</translation>
  </message>
  <message>
   <source>finding its tangents</source>
   <translation>Tangenten werden bestimmt</translation>
  </message>
  <message>
   <source>reading the environment</source>
   <translation>Umgebung wird gelesen</translation>
  </message>
  <message>
   <source>choosing directions</source>
   <translation>Richtungen werden gewählt</translation>
  </message>
  <message>
   <source>its photographs give other results than they did</source>
   <translation>seine Fotos ergeben andere Ergebnisse als zuvor</translation>
  </message>
  <message>
   <source>Open it and build it again</source>
   <translation>Öffnen und neu erzeugen</translation>
  </message>
  <message>
   <source>capture or material</source>
   <translation>Aufnahme oder Material</translation>
  </message>
  <message>
   <source>A project holds one %1, here %2. Open this one alone to replace it</source>
   <translation>Ein Projekt enthält nur eines: %1, hier %2. Dieses allein öffnen, um es zu ersetzen</translation>
  </message>
  <message>
   <source>is a second %1</source>
   <translation>gehört zu einem zweiten: %1</translation>
  </message>
  <message>
   <source>does not exist</source>
   <translation>existiert nicht</translation>
  </message>
  <message>
   <source>Check the path, or whether its drive is connected</source>
   <translation>Den Pfad prüfen, oder ob sein Laufwerk verbunden ist</translation>
  </message>
  <message>
   <source>is not a photograph that Lightarc reads</source>
   <translation>ist kein Foto, das Lightarc liest</translation>
  </message>
  <message>
   <source>Open it together with the photographs</source>
   <translation>Zusammen mit den Fotos öffnen</translation>
  </message>
  <message>
   <source>is not a kind of file that Lightarc opens</source>
   <translation>ist keine Art von Datei, die Lightarc öffnet</translation>
  </message>
  <message>
   <source>Open photographs (a folder or an archive), a model (OBJ, PLY, STL, glTF, USD), an environment (HDR, EXR), a measured BRDF (MERL, RGL, …), a folder of factors, a .lightarc bundle, PBR textures, a MaterialX document, or RTI files (PTM, HSH)</source>
   <translation>Fotos (Ordner oder Archiv), ein Modell (OBJ, PLY, STL, glTF, USD), eine Umgebung (HDR, EXR), eine gemessene BRDF (MERL, RGL, …), einen Ordner mit Faktoren, ein .lightarc-Paket, PBR-Texturen, ein MaterialX-Dokument oder RTI-Dateien (PTM, HSH) öffnen</translation>
  </message>
  <message>
   <source>cannot be read (%1)</source>
   <translation>lässt sich nicht lesen (%1)</translation>
  </message>
  <message>
   <source>Check the permissions of the file</source>
   <translation>Die Rechte der Datei prüfen</translation>
  </message>
  <message>
   <source>Install the extra usd (pip install 'lightarc[usd]'), or drop a glTF file</source>
   <translation>Das Zusatzpaket usd installieren (pip install 'lightarc[usd]') oder eine glTF-Datei hierher ziehen</translation>
  </message>
  <message>
   <source>is a USD package whose textures are not named for what they hold</source>
   <translation>ist ein USD-Paket, dessen Texturen nicht nach ihrem Inhalt benannt sind</translation>
  </message>
  <message>
   <source>the run in the project has no result: it was stopped before it had one</source>
   <translation>der Lauf im Projekt hat kein Ergebnis: er wurde vorher beendet</translation>
  </message>
  <message>
   <source>its result is gone from the data folder</source>
   <translation>sein Ergebnis fehlt im Datenordner</translation>
  </message>
  <message>
   <source>every value is the same</source>
   <translation>jeder Wert ist gleich</translation>
  </message>
  <message>
   <source>it is of another state of the project, whose model, ground or BRDF was another one</source>
   <translation>es gehört zu einem anderen Stand des Projekts mit anderem Modell, Boden oder anderer BRDF</translation>
  </message>
  <message>
   <source>the search had not come to its end</source>
   <translation>die Suche war noch nicht zu Ende</translation>
  </message>
  <message>
   <source>the BRDF that it was fitted to is compared no longer</source>
   <translation>die BRDF, an die angepasst wurde, wird nicht mehr verglichen</translation>
  </message>
  <message>
   <source>parameters were turned by hand, the fit was stopped before its end, or the machine differs</source>
   <translation>Parameter wurden von Hand geändert, die Anpassung wurde vorher beendet, oder der Rechner ist ein anderer</translation>
  </message>
  <message>
   <source>fit %1</source>
   <translation>Anpassung %1</translation>
  </message>
  <message>
   <source>factors of %1, %2</source>
   <translation>Faktoren von %1, %2</translation>
  </message>
  <message>
   <source>bake %1</source>
   <translation>Vorberechnung %1</translation>
  </message>
  <message>
   <source>nobody noted how it was made</source>
   <translation>wie es entstand, wurde nicht vermerkt</translation>
  </message>
  <message>
   <source>it cannot be made again: %1</source>
   <translation>es lässt sich nicht neu erzeugen: %1</translation>
  </message>
  <message>
   <source>settings are the same, versions or machine differ</source>
   <translation>Einstellungen sind gleich, Versionen oder Rechner verschieden</translation>
  </message>
  <message>
   <source>lightarc %1</source>
   <translation>lightarc %1</translation>
  </message>
  <message>
   <source>it was made by %1, not %2</source>
   <translation>es wurde von %1 erzeugt, nicht von %2</translation>
  </message>
  <message>
   <source>settings are the same, the machine differs</source>
   <translation>Einstellungen sind gleich, der Rechner ist ein anderer</translation>
  </message>
  <message>
   <source>%1 differ: %2</source>
   <translation>%1 verschieden: %2</translation>
  </message>
  <message>
   <source>shading map</source>
   <translation>Schattierungskarte</translation>
  </message>
  <message>
   <source>directional map</source>
   <translation>Richtungskarte</translation>
  </message>
  <message>
   <source>the project has no such result to compare with</source>
   <translation>das Projekt hat kein solches Ergebnis zum Vergleich</translation>
  </message>
  <message>
   <source>it came from a file and was not made of photographs here</source>
   <translation>es stammt aus einer Datei und entstand nicht hier aus Fotos</translation>
  </message>
  <message>
   <source>times and errors are those of one machine at one time, and can only be measured again</source>
   <translation>Zeiten und Fehler gelten für einen Rechner zu einer Zeit und lassen sich nur neu messen</translation>
  </message>
  <message>
   <source>the photographs were imported again after they were made</source>
   <translation>die Fotos wurden danach neu importiert</translation>
  </message>
  <message>
   <source>the settings were changed after it was built</source>
   <translation>die Einstellungen wurden danach geändert</translation>
  </message>
  <message>
   <source>was not made from photographs and has no runs, fits or bakes to repeat</source>
   <translation>entstand nicht aus Fotos und hat keine Läufe, Anpassungen oder Vorberechnungen zum Wiederholen</translation>
  </message>
  <message>
   <source>Choose another project</source>
   <translation>Ein anderes Projekt wählen</translation>
  </message>
  <message>
   <source>is missing (%1 of the photographs)</source>
   <translation>fehlt (%1 der Fotos)</translation>
  </message>
  <message>
   <source>Put the photographs back</source>
   <translation>Die Fotos zurücklegen</translation>
  </message>
  <message>
   <source>measured accuracy</source>
   <translation>gemessene Genauigkeit</translation>
  </message>
  <message>
   <source>surface maps</source>
   <translation>Oberflächenkarten</translation>
  </message>
  <message>
   <source>photographs, settings or machine differ</source>
   <translation>Fotos, Einstellungen oder Rechner verschieden</translation>
  </message>
  <message>
   <source>Making surface maps</source>
   <translation>Oberflächenkarten werden erzeugt</translation>
  </message>
  <message>
   <source>White reference</source>
   <translation>Weiße Referenz</translation>
  </message>
  <message>
   <source>Surface maps made</source>
   <translation>Oberflächenkarten erzeugt</translation>
  </message>
  <message>
   <source>Writing surface maps</source>
   <translation>Oberflächenkarten werden geschrieben</translation>
  </message>
  <message>
   <source>%1 files written to %2</source>
   <translation>%1 Dateien nach %2 geschrieben</translation>
  </message>
  <message>
   <source>writing maps</source>
   <translation>Karten werden geschrieben</translation>
  </message>
  <message>
   <source>Woven sample</source>
   <translation>Gewebte Probe</translation>
  </message>
  <message>
   <source>sample capture</source>
   <translation>Beispielaufnahme</translation>
  </message>
  <message>
   <source>%1 has a material of its own, which was not opened: %2 came with it</source>
   <translation>%1 hat ein eigenes Material, das nicht geöffnet wurde: %2 kam mit</translation>
  </message>
  <message>
   <source>Opening</source>
   <translation>Wird geöffnet</translation>
  </message>
  <message>
   <source>Preparing the sample capture</source>
   <translation>Beispielaufnahme wird vorbereitet</translation>
  </message>
  <message>
   <source>imports all photographs together, as one capture of one sample</source>
   <translation>importiert alle Fotos zusammen, als eine Aufnahme einer Probe</translation>
  </message>
  <message>
   <source>Opening the material</source>
   <translation>Material wird geöffnet</translation>
  </message>
  <message>
   <source>Opening the bundle</source>
   <translation>Paket wird geöffnet</translation>
  </message>
  <message>
   <source>Opening the stack</source>
   <translation>Stapel wird geöffnet</translation>
  </message>
  <message>
   <source>Looking for its material</source>
   <translation>Material dazu wird gesucht</translation>
  </message>
  <message>
   <source>opens the model alone, and keeps the material of this project</source>
   <translation>öffnet nur das Modell und behält das Material dieses Projekts</translation>
  </message>
  <message>
   <source>Looking for photographs</source>
   <translation>Fotos werden gesucht</translation>
  </message>
  <message>
   <source>Joining the photographs</source>
   <translation>Fotos werden zusammengeführt</translation>
  </message>
  <message>
   <source>Open %1 photographs</source>
   <translation>%1 Fotos öffnen</translation>
  </message>
  <message>
   <source>Importing photographs</source>
   <translation>Fotos werden importiert</translation>
  </message>
  <message>
   <source>stacks of %1</source>
   <translation>Stapel von %1</translation>
  </message>
  <message>
   <source>Import photographs</source>
   <translation>Fotos importieren</translation>
  </message>
  <message>
   <source>%1 photographs imported</source>
   <translation>%1 Fotos importiert</translation>
  </message>
  <message>
   <source>Open %1</source>
   <translation>%1 öffnen</translation>
  </message>
  <message>
   <source>The stack %1 is open</source>
   <translation>Der Stapel %1 ist geöffnet</translation>
  </message>
  <message>
   <source>%1 photographs</source>
   <translation>%1 Fotos</translation>
  </message>
  <message>
   <source>Exclude</source>
   <translation>Ausschließen</translation>
  </message>
  <message>
   <source>Include</source>
   <translation>Einschließen</translation>
  </message>
  <message>
   <source>Use all photographs</source>
   <translation>Alle Fotos verwenden</translation>
  </message>
  <message>
   <source>Use %1 photographs</source>
   <translation>%1 Fotos verwenden</translation>
  </message>
  <message>
   <source>Building the material</source>
   <translation>Material wird erzeugt</translation>
  </message>
  <message>
   <source>Material built</source>
   <translation>Material erzeugt</translation>
  </message>
  <message>
   <source>Show the image flat</source>
   <translation>Bild flach zeigen</translation>
  </message>
  <message>
   <source>Model %1</source>
   <translation>Modell %1</translation>
  </message>
  <message>
   <source>Opening the environment</source>
   <translation>Umgebung wird geöffnet</translation>
  </message>
  <message>
   <source>naming the state of the project</source>
   <translation>Stand des Projekts wird benannt</translation>
  </message>
  <message>
   <source>%1 %2 opened</source>
   <translation>%1 %2 geöffnet</translation>
  </message>
  <message>
   <source>recognising files</source>
   <translation>Dateien werden erkannt</translation>
  </message>
  <message>
   <source>joining the photographs</source>
   <translation>Fotos werden zusammengeführt</translation>
  </message>
  <message>
   <source>opening the stack</source>
   <translation>Stapel wird geöffnet</translation>
  </message>
 </context>
 <context>
  <name>batch</name>
  <message>
   <source>holds no capture</source>
   <translation>enthält keine Aufnahme</translation>
  </message>
  <message>
   <source>Give folders of photographs, or a table of them (.csv)</source>
   <translation>Geben Sie Ordner mit Fotos an, oder eine Tabelle davon (.csv)</translation>
  </message>
  <message>
   <source>makes more than %1 captures</source>
   <translation>ergibt mehr als %1 Aufnahmen</translation>
  </message>
  <message>
   <source>Divide it into several batches</source>
   <translation>Teilen Sie sie auf mehrere Stapel auf</translation>
  </message>
  <message>
   <source>Check its name, or put a pattern into quotes</source>
   <translation>Prüfen Sie den Namen, oder setzen Sie ein Muster in Anführungszeichen</translation>
  </message>
  <message>
   <source>lies more than %1 folders deep</source>
   <translation>liegt mehr als %1 Ordner tief</translation>
  </message>
  <message>
   <source>Give a folder that is nearer</source>
   <translation>Geben Sie einen Ordner an, der näher liegt</translation>
  </message>
  <message>
   <source>needs a first row that names its columns, each once, with one called path</source>
   <translation>braucht eine erste Zeile, die jede Spalte einmal nennt, davon eine namens path</translation>
  </message>
  <message>
   <source>Begin it with path,name,options and columns for metadata</source>
   <translation>Beginnen Sie sie mit path,name,options und Spalten für Metadaten</translation>
  </message>
  <message>
   <source>names the same photographs with the same options in rows %1 and %2</source>
   <translation>nennt in den Zeilen %1 und %2 dieselben Fotos mit denselben Optionen</translation>
  </message>
  <message>
   <source>Leave one of them out, or give it other options</source>
   <translation>Lassen Sie eine davon weg, oder geben Sie ihr andere Optionen</translation>
  </message>
  <message>
   <source>has more than %1 rows</source>
   <translation>hat mehr als %1 Zeilen</translation>
  </message>
  <message>
   <source>Divide it</source>
   <translation>Teilen Sie sie</translation>
  </message>
  <message>
   <source>is no table of cells (%1)</source>
   <translation>ist keine Tabelle mit Zellen (%1)</translation>
  </message>
  <message>
   <source>Save it as CSV again</source>
   <translation>Speichern Sie sie noch einmal als CSV</translation>
  </message>
  <message>
   <source>has more cells in row %1 than it has columns, or one that is too long</source>
   <translation>hat in Zeile %1 mehr Zellen als Spalten, oder eine zu lange</translation>
  </message>
  <message>
   <source>Put cells that hold separators into quotation marks</source>
   <translation>Setzen Sie Zellen mit Trennzeichen in Anführungszeichen</translation>
  </message>
  <message>
   <source>has no path in row %1</source>
   <translation>hat in Zeile %1 keinen Pfad</translation>
  </message>
  <message>
   <source>Name the folder of the photographs there</source>
   <translation>Nennen Sie dort den Ordner der Fotos</translation>
  </message>
  <message>
   <source>has an option in row %1 that is none (%2)</source>
   <translation>hat in Zeile %1 eine Option, die keine ist (%2)</translation>
  </message>
  <message>
   <source>See lightarc batch -h</source>
   <translation>Siehe lightarc batch -h</translation>
  </message>
  <message>
   <source>Making captures</source>
   <translation>Aufnahmen zu verarbeiten</translation>
  </message>
  <message>
   <source>The workers that made it were lost; their logs say why.</source>
   <translation>Die Worker, die sie verarbeiteten, gingen verloren; ihre Protokolle sagen, warum.</translation>
  </message>
  <message>
   <source>Install Lightarc %1 where scheduler and workers run and start again</source>
   <translation>Installieren Sie Lightarc %1, wo Scheduler und Worker laufen, und starten Sie noch einmal</translation>
  </message>
  <message>
   <source>the cluster could not do its part (%1)</source>
   <translation>der Cluster konnte seinen Teil nicht leisten (%1)</translation>
  </message>
  <message>
   <source>looking for photographs</source>
   <translation>Fotos werden gesucht</translation>
  </message>
  <message>
   <source>writing the project</source>
   <translation>Das Projekt wird geschrieben</translation>
  </message>
  <message>
   <source>State</source>
   <translation>Zustand</translation>
  </message>
  <message>
   <source>Held-out error</source>
   <translation>Fehler ausgelassener Fotos</translation>
  </message>
  <message>
   <source>Running</source>
   <translation>Läuft</translation>
  </message>
  <message>
   <source>Failed</source>
   <translation>Fehlgeschlagen</translation>
  </message>
  <message>
   <source>Batch</source>
   <translation>Stapel</translation>
  </message>
  <message>
   <source>Progress of the batch</source>
   <translation>Fortschritt des Stapels</translation>
  </message>
  <message>
   <source>Captures of the batch</source>
   <translation>Aufnahmen des Stapels</translation>
  </message>
  <message>
   <source>Many captures in one run</source>
   <translation>Viele Aufnahmen in einem Lauf</translation>
  </message>
  <message>
   <source>Folder…</source>
   <translation>Ordner…</translation>
  </message>
  <message>
   <source>Table…</source>
   <translation>Tabelle…</translation>
  </message>
  <message>
   <source>Choose…</source>
   <translation>Wählen…</translation>
  </message>
  <message>
   <source>A folder with a folder for each capture, or a table (.csv) that lists them</source>
   <translation>Ein Ordner mit einem Ordner für jede Aufnahme, oder eine Tabelle (.csv), die sie aufzählt</translation>
  </message>
  <message>
   <source>Captures</source>
   <translation>Aufnahmen</translation>
  </message>
  <message>
   <source>A folder for each capture and for the report; one of an earlier batch goes on</source>
   <translation>Ein Ordner für jede Aufnahme und den Bericht; der eines früheren Stapels wird fortgesetzt</translation>
  </message>
  <message>
   <source>Results</source>
   <translation>Ergebnisse</translation>
  </message>
  <message>
   <source>As this project</source>
   <translation>Wie dieses Projekt</translation>
  </message>
  <message>
   <source>As a new project</source>
   <translation>Wie ein neues Projekt</translation>
  </message>
  <message>
   <source>Choices</source>
   <translation>Einstellungen</translation>
  </message>
  <message>
   <source>Import, material, appearance and exports of all captures</source>
   <translation>Import, Material, Aussehen und Exporte aller Aufnahmen</translation>
  </message>
  <message>
   <source>Start</source>
   <translation>Starten</translation>
  </message>
  <message>
   <source>Open report</source>
   <translation>Bericht öffnen</translation>
  </message>
  <message>
   <source>Folder of captures</source>
   <translation>Ordner der Aufnahmen</translation>
  </message>
  <message>
   <source>Table of captures</source>
   <translation>Tabelle der Aufnahmen</translation>
  </message>
  <message>
   <source>Tables (*.csv)</source>
   <translation>Tabellen (*.csv)</translation>
  </message>
  <message>
   <source>Folder of results</source>
   <translation>Ordner der Ergebnisse</translation>
  </message>
  <message>
   <source>It goes on where it stopped when it is started again.</source>
   <translation>Beim nächsten Start geht es dort weiter, wo er aufhörte.</translation>
  </message>
  <message>
   <source>%1 of %2 captures are done</source>
   <translation>%1 von %2 Aufnahmen sind fertig</translation>
  </message>
  <message>
   <source>It is running</source>
   <translation>Er läuft</translation>
  </message>
  <message>
   <source>Choose a folder of results</source>
   <translation>Wählen Sie einen Ordner für Ergebnisse</translation>
  </message>
  <message>
   <source>Choose captures</source>
   <translation>Wählen Sie Aufnahmen</translation>
  </message>
  <message>
   <source>Go on</source>
   <translation>Fortsetzen</translation>
  </message>
  <message>
   <source>Nothing is running</source>
   <translation>Nichts läuft</translation>
  </message>
  <message>
   <source>Captures that are being made come to their end</source>
   <translation>Begonnene Aufnahmen werden noch fertig</translation>
  </message>
  <message>
   <source>Captures that are being made start over later</source>
   <translation>Begonnene Aufnahmen fangen später neu an</translation>
  </message>
  <message>
   <source>There is no report yet</source>
   <translation>Es gibt noch keinen Bericht</translation>
  </message>
  <message>
   <source>It was stopped.</source>
   <translation>Sie wurde angehalten.</translation>
  </message>
  <message>
   <source>No further process can be started (%1)</source>
   <translation>Es kann kein weiterer Prozess gestartet werden (%1)</translation>
  </message>
  <message>
   <source>It took longer than %1, the limit of a capture. Give --time-limit.</source>
   <translation>Sie dauerte länger als %1, die Grenze für eine Aufnahme. Geben Sie --time-limit an.</translation>
  </message>
  <message>
   <source>Its process ended %1 times (%2); its log says where.</source>
   <translation>Ihr Prozess endete %1-mal (%2); ihr Protokoll sagt, wo.</translation>
  </message>
  <message>
   <source>signal %1</source>
   <translation>Signal %1</translation>
  </message>
  <message>
   <source>exit code %1</source>
   <translation>Exit-Code %1</translation>
  </message>
  <message>
   <source>another run is at work on this batch</source>
   <translation>ein anderer Lauf arbeitet an diesem Stapel</translation>
  </message>
  <message>
   <source>Wait until it has ended, or stop it</source>
   <translation>Warten Sie, bis er beendet ist, oder halten Sie ihn an</translation>
  </message>
  <message>
   <source>the disk is full</source>
   <translation>der Datenträger ist voll</translation>
  </message>
  <message>
   <source>Free some space or choose another disk</source>
   <translation>Platz schaffen oder einen anderen Datenträger wählen</translation>
  </message>
  <message>
   <source>writing here is not permitted</source>
   <translation>Schreiben ist hier nicht erlaubt</translation>
  </message>
  <message>
   <source>Choose another folder or change its permissions</source>
   <translation>Einen anderen Ordner wählen oder seine Rechte ändern</translation>
  </message>
  <message>
   <source>Remove it, and name the captures again: those that are done are not made again</source>
   <translation>Entfernen Sie sie, und geben Sie die Aufnahmen noch einmal an: fertige werden nicht noch einmal gemacht</translation>
  </message>
  <message>
   <source>is not the record of a batch</source>
   <translation>ist nicht das Protokoll eines Stapels</translation>
  </message>
  <message>
   <source>Choose another folder for the results</source>
   <translation>Wählen Sie einen anderen Ordner für die Ergebnisse</translation>
  </message>
  <message>
   <source>was made by a newer version</source>
   <translation>stammt von einer neueren Version</translation>
  </message>
  <message>
   <source>Update Lightarc</source>
   <translation>Lightarc aktualisieren</translation>
  </message>
  <message>
   <source>cannot be read or written (%1)</source>
   <translation>lässt sich nicht lesen oder schreiben (%1)</translation>
  </message>
  <message>
   <source>is damaged (%1)</source>
   <translation>ist beschädigt (%1)</translation>
  </message>
  <message>
   <source>a time limit of %1 s is outside %2 … %3</source>
   <translation>ein Zeitlimit von %1 s liegt nicht zwischen %2 und %3</translation>
  </message>
  <message>
   <source>looking for captures</source>
   <translation>Aufnahmen werden gesucht</translation>
  </message>
  <message>
   <source>there is no capture: name folders of photographs, or a table of them</source>
   <translation>es gibt keine Aufnahme: nennen Sie Ordner mit Fotos, oder eine Tabelle davon</translation>
  </message>
  <message>
   <source>%1 of %2 captures</source>
   <translation>%1 von %2 Aufnahmen</translation>
  </message>
  <message>
   <source>%1 of %2 captures, %3</source>
   <translation>%1 von %2 Aufnahmen, %3</translation>
  </message>
 </context>
 <context>
  <name>watch</name>
  <message>
   <source>Install it with: pip install 'lightarc[camera]'</source>
   <translation>Installieren Sie sie mit: pip install 'lightarc[camera]'</translation>
  </message>
  <message>
   <source>Photographs from a camera need the library gphoto2</source>
   <translation>Fotos von einer Kamera brauchen die Bibliothek gphoto2</translation>
  </message>
  <message>
   <source>Check that it is switched on, connected, and not in use by another program (as a file manager)</source>
   <translation>Prüfen Sie, dass sie eingeschaltet und verbunden ist und von keinem anderen Programm (wie einem Dateimanager) benutzt wird</translation>
  </message>
  <message>
   <source>the camera</source>
   <translation>die Kamera</translation>
  </message>
  <message>
   <source>cannot be used (%1)</source>
   <translation>ist nicht verwendbar (%1)</translation>
  </message>
  <message>
   <source>a memory card…</source>
   <translation>eine Speicherkarte …</translation>
  </message>
  <message>
   <source>Filled: the photograph is there. Hollow: it is expected. The preview is lit from where the mouse is</source>
   <translation>Gefüllt: Das Foto ist da. Hohl: Es wird erwartet. Die Vorschau wird von dort beleuchtet, wo die Maus ist</translation>
  </message>
  <message>
   <source>%1
elevation %2°, azimuth %3°</source>
   <translation>%1
Elevation %2°, Azimut %3°</translation>
  </message>
  <message>
   <source>Preview under a moved light</source>
   <translation>Vorschau unter bewegtem Licht</translation>
  </message>
  <message>
   <source>A preview from thumbnails: move the mouse over the dome to light it</source>
   <translation>Eine Vorschau aus Miniaturen: Die Maus über der Kuppel beleuchtet sie</translation>
  </message>
  <message>
   <source>A preview appears as soon as lamps of photographs are known</source>
   <translation>Eine Vorschau erscheint, sobald Lampen von Fotos bekannt sind</translation>
  </message>
  <message>
   <source>Watch</source>
   <translation>Mitverfolgen</translation>
  </message>
  <message>
   <source>Photographs that are there</source>
   <translation>Fotos, die da sind</translation>
  </message>
  <message>
   <source>Take photographs in while they are taken</source>
   <translation>Fotos übernehmen, während sie aufgenommen werden</translation>
  </message>
  <message>
   <source>The folder in which the camera or the controller of the dome writes its photographs</source>
   <translation>Der Ordner, in den die Kamera oder die Steuerung der Lichtkuppel ihre Fotos schreibt</translation>
  </message>
  <message>
   <source>as listed</source>
   <translation>wie gelistet</translation>
  </message>
  <message>
   <source>The capture ends when so many are there; without a number, as many as a list of lights names</source>
   <translation>Die Aufnahme endet, wenn so viele da sind; ohne Zahl so viele, wie eine Liste der Lichter nennt</translation>
  </message>
  <message>
   <source>no camera</source>
   <translation>keine Kamera</translation>
  </message>
  <message>
   <source>the one on a cable</source>
   <translation>die am Kabel</translation>
  </message>
  <message>
   <source>What the camera takes from now on is copied into the folder; nothing is changed on the camera</source>
   <translation>Was die Kamera von nun an aufnimmt, wird in den Ordner kopiert; auf der Kamera ändert sich nichts</translation>
  </message>
  <message>
   <source>Folder of the memory card</source>
   <translation>Ordner der Speicherkarte</translation>
  </message>
  <message>
   <source>memory card %1</source>
   <translation>Speicherkarte %1</translation>
  </message>
  <message>
   <source>Finish</source>
   <translation>Fertig</translation>
  </message>
  <message>
   <source>Watching a folder</source>
   <translation>Ein Ordner wird verfolgt</translation>
  </message>
  <message>
   <source>Cancelled; the photographs stay in their folder</source>
   <translation>Abgebrochen; die Fotos bleiben in ihrem Ordner</translation>
  </message>
  <message>
   <source>Waiting for photographs</source>
   <translation>Wartet auf Fotos</translation>
  </message>
  <message>
   <source>A capture needs two photographs at least</source>
   <translation>Eine Aufnahme braucht mindestens zwei Fotos</translation>
  </message>
  <message>
   <source>%1 photographs are there, and are imported</source>
   <translation>%1 Fotos sind da und werden importiert</translation>
  </message>
  <message>
   <source>Lights cover %1 of the dome</source>
   <translation>Lichter decken %1 der Kuppel ab</translation>
  </message>
  <message>
   <source>Choose a folder</source>
   <translation>Wählen Sie einen Ordner</translation>
  </message>
  <message>
   <source>Import the photographs that are there</source>
   <translation>Die Fotos importieren, die da sind</translation>
  </message>
 </context>
 <context>
  <name>jobs</name>
  <message>
   <source>Writes what the user confirmed: starts at once, and closing the window waits for it.</source>
   <translation>Writes what the user confirmed: starts at once, and closing the window waits for it.</translation>
  </message>
  <message>
   <source>Brings a file into the program: starts at once, `MAX_OPEN` side by side.</source>
   <translation>Brings a file into the program: starts at once, `MAX_OPEN` side by side.</translation>
  </message>
  <message>
   <source>A computation that the user asked for: `max_compute` side by side, first come first.</source>
   <translation>A computation that the user asked for: `max_compute` side by side, first come first.</translation>
  </message>
  <message>
   <source>Nobody waits for it: runs, step by step, while no job of the lanes above does.</source>
   <translation>Nobody waits for it: runs, step by step, while no job of the lanes above does.</translation>
  </message>
  <message>
   <source>An image or a figure for the screen: starts at once, and is not listed.</source>
   <translation>An image or a figure for the screen: starts at once, and is not listed.</translation>
  </message>
  <message>
   <source>%1 to end</source>
   <translation>%1</translation>
  </message>
  <message>
   <source>%1 and %2 others to end</source>
   <translation>%1 und %2 andere</translation>
  </message>
  <message>
   <source>%1, which measures times and runs alone</source>
   <translation>%1, misst Zeiten und läuft allein</translation>
  </message>
  <message>
   <source>%1 to end, because it measures times</source>
   <translation>%1, weil Zeiten gemessen werden</translation>
  </message>
  <message>
   <source>%1 or %2 to end</source>
   <translation>%1 oder %2</translation>
  </message>
  <message>
   <source>one of %1 others</source>
   <translation>einen von %1 anderen</translation>
  </message>
  <message>
   <source>memory: %1 of %2 are free</source>
   <translation>Speicher: %1 von %2 sind frei</translation>
  </message>
  <message>
   <source>No further thread can be started</source>
   <translation>Kein weiterer Thread lässt sich starten</translation>
  </message>
 </context>
 <context>
  <name>project</name>
  <message>
   <source>is damaged: its content is not the one of its name</source>
   <translation>ist beschädigt: sein Inhalt ist nicht der seines Namens</translation>
  </message>
  <message>
   <source>Make it again</source>
   <translation>Neu erzeugen</translation>
  </message>
  <message>
   <source>data that can be made again</source>
   <translation>Daten, die sich neu erzeugen lassen</translation>
  </message>
  <message>
   <source>data that cannot be read (%1)</source>
   <translation>Daten, die sich nicht lesen lassen (%1)</translation>
  </message>
  <message>
   <source>is damaged: it is empty</source>
   <translation>ist beschädigt: es ist leer</translation>
  </message>
  <message>
   <source>is damaged: %1</source>
   <translation>ist beschädigt: %1</translation>
  </message>
  <message>
   <source>is damaged: %1 of %2 are not %3 bytes</source>
   <translation>ist beschädigt: %1 von %2 sind nicht %3 Bytes</translation>
  </message>
  <message>
   <source>%1 cannot be read: %2</source>
   <translation>%1 lässt sich nicht lesen: %2</translation>
  </message>
  <message>
   <source>reading %1</source>
   <translation>%1 wird gelesen</translation>
  </message>
  <message>
   <source>%1 is damaged, and can be made again</source>
   <translation>%1 ist beschädigt und lässt sich neu erzeugen</translation>
  </message>
  <message>
   <source>file %1</source>
   <translation>Datei %1</translation>
  </message>
  <message>
   <source>looking for a bake</source>
   <translation>Vorberechnung wird gesucht</translation>
  </message>
  <message>
   <source>keeping results</source>
   <translation>Ergebnisse werden gespeichert</translation>
  </message>
  <message>
   <source>reading results</source>
   <translation>Ergebnisse werden gelesen</translation>
  </message>
  <message>
   <source>reading the project</source>
   <translation>Projekt wird gelesen</translation>
  </message>
  <message>
   <source>is or holds a link to elsewhere</source>
   <translation>ist oder enthält einen Verweis nach außen</translation>
  </message>
  <message>
   <source>Copy the project, and clean up the copy</source>
   <translation>Das Projekt kopieren und die Kopie aufräumen</translation>
  </message>
  <message>
   <source>Bakes stay while the project is open</source>
   <translation>Vorberechnungen bleiben, solange das Projekt geöffnet ist</translation>
  </message>
  <message>
   <source>cleaned up</source>
   <translation>aufgeräumt</translation>
  </message>
  <message>
   <source>Recover it first: lightarc project recover</source>
   <translation>Zuerst wiederherstellen: lightarc project recover</translation>
  </message>
  <message>
   <source>not as they were when they were imported</source>
   <translation>nicht wie beim Import</translation>
  </message>
  <message>
   <source>not marked as they were imported</source>
   <translation>nicht als unverändert vermerkt</translation>
  </message>
  <message>
   <source>%1 %2. The results made of them stay</source>
   <translation>%1 %2. Die daraus erzeugten Ergebnisse bleiben</translation>
  </message>
  <message>
   <source>The photographs were imported by %1. Import them again to make their results smaller</source>
   <translation>Die Fotos wurden mit %1 importiert. Ein neuer Import macht ihre Ergebnisse kleiner</translation>
  </message>
  <message>
   <source>names files outside its folder, which a collected project would hold: %1</source>
   <translation>nennt Dateien außerhalb seines Ordners, die ein gesammeltes Projekt enthielte: %1</translation>
  </message>
  <message>
   <source>Look at them, and give --include-outside to copy them too</source>
   <translation>Die Dateien ansehen und --include-outside angeben, um sie mitzukopieren</translation>
  </message>
  <message>
   <source>Say where they are now, or copy</source>
   <translation>Angeben, wo sie jetzt sind, oder kopieren</translation>
  </message>
  <message>
   <source>Close it there, or choose another name</source>
   <translation>Dort schließen oder einen anderen Namen wählen</translation>
  </message>
  <message>
   <source>exists already</source>
   <translation>existiert bereits</translation>
  </message>
  <message>
   <source>Choose another name, or remove it first</source>
   <translation>Einen anderen Namen wählen oder es zuerst entfernen</translation>
  </message>
  <message>
   <source>copying %1</source>
   <translation>%1 wird kopiert</translation>
  </message>
  <message>
   <source>decoding %1</source>
   <translation>%1 wird dekodiert</translation>
  </message>
  <message>
   <source>`lightarc project find` with the folder of the photographs records those that are there</source>
   <translation>„lightarc project find“ mit dem Ordner der Fotos verzeichnet die vorhandenen</translation>
  </message>
  <message>
   <source>is named by the project, which has no record of its content</source>
   <translation>wird vom Projekt genannt, das seinen Inhalt nicht verzeichnet hat</translation>
  </message>
  <message>
   <source>is not the file that the project recorded</source>
   <translation>ist nicht die Datei, die das Projekt verzeichnet hat</translation>
  </message>
  <message>
   <source>measured BRDF</source>
   <translation>gemessene BRDF</translation>
  </message>
  <message>
   <source>is not a usable %1 (%2)</source>
   <translation>ist nicht brauchbar als %1 (%2)</translation>
  </message>
  <message>
   <source>Remove it from the project, or copy it</source>
   <translation>Aus dem Projekt entfernen oder kopieren</translation>
  </message>
  <message>
   <source>Choose a project that Lightarc has written (.lap)</source>
   <translation>Ein Projekt wählen, das Lightarc geschrieben hat (.lap)</translation>
  </message>
  <message>
   <source>`lightarc project recover` saves what is sound in a new project</source>
   <translation>„lightarc project recover“ sichert Unbeschädigtes in einem neuen Projekt</translation>
  </message>
  <message>
   <source>Check its permissions and the disk that it lies on</source>
   <translation>Seine Rechte und den Datenträger prüfen</translation>
  </message>
  <message>
   <source>there is no such project</source>
   <translation>es gibt kein solches Projekt</translation>
  </message>
  <message>
   <source>Check the name, or open the folder that it was moved to</source>
   <translation>Den Namen prüfen oder den Ordner öffnen, in den es verschoben wurde</translation>
  </message>
  <message>
   <source>cannot be opened (%1)</source>
   <translation>lässt sich nicht öffnen (%1)</translation>
  </message>
  <message>
   <source>Check the folder's permissions and free space</source>
   <translation>Rechte und freien Platz des Ordners prüfen</translation>
  </message>
  <message>
   <source>is not a Lightarc project</source>
   <translation>ist kein Lightarc-Projekt</translation>
  </message>
  <message>
   <source>it needs a write-ahead log, which no project has</source>
   <translation>es braucht ein Write-Ahead-Protokoll, das kein Projekt hat</translation>
  </message>
  <message>
   <source>is not a Lightarc journal</source>
   <translation>ist kein Lightarc-Journal</translation>
  </message>
  <message>
   <source>Remove it; it did not come from this program</source>
   <translation>Entfernen; es stammt nicht von diesem Programm</translation>
  </message>
  <message>
   <source>it has no table meta</source>
   <translation>es hat keine Tabelle meta</translation>
  </message>
  <message>
   <source>it holds the %1 %2, which no project has</source>
   <translation>es enthält %1 %2, was kein Projekt hat</translation>
  </message>
  <message>
   <source>it has no table %1</source>
   <translation>es hat keine Tabelle %1</translation>
  </message>
  <message>
   <source>its texts are not in UTF-8</source>
   <translation>seine Texte sind nicht in UTF-8</translation>
  </message>
  <message>
   <source>it holds tables that no project has</source>
   <translation>es enthält Tabellen, die kein Projekt hat</translation>
  </message>
  <message>
   <source>its table %1 holds values of other types or lengths</source>
   <translation>seine Tabelle %1 enthält Werte anderer Typen oder Längen</translation>
  </message>
  <message>
   <source>it does not say its version</source>
   <translation>es nennt seine Version nicht</translation>
  </message>
  <message>
   <source>%1, schema %2; this one reads up to %3</source>
   <translation>%1, Schema %2; dieses liest bis %3</translation>
  </message>
  <message>
   <source>was made by a newer version (%1)</source>
   <translation>wurde von einer neueren Version erzeugt (%1)</translation>
  </message>
  <message>
   <source>%1 (schema %2%3)%4</source>
   <translation>%1 (Schema %2%3)%4</translation>
  </message>
  <message>
   <source>another program keeps it locked</source>
   <translation>ein anderes Programm hält es gesperrt</translation>
  </message>
  <message>
   <source>Close that program</source>
   <translation>Dieses Programm schließen</translation>
  </message>
  <message>
   <source>its path is too long</source>
   <translation>sein Pfad ist zu lang</translation>
  </message>
  <message>
   <source>Choose a shorter name, or a folder that is nearer to the root</source>
   <translation>Einen kürzeren Namen wählen oder einen Ordner näher an der Wurzel</translation>
  </message>
  <message>
   <source>a text is not in UTF-8</source>
   <translation>ein Text ist nicht in UTF-8</translation>
  </message>
  <message>
   <source>reading it takes more work than a file of its size can need</source>
   <translation>das Lesen braucht mehr Arbeit, als eine Datei dieser Größe nötig machen kann</translation>
  </message>
  <message>
   <source>Look</source>
   <translation>Ansicht</translation>
  </message>
  <message>
   <source>Comparison</source>
   <translation>Vergleich</translation>
  </message>
  <message>
   <source>Entry</source>
   <translation>Eintrag</translation>
  </message>
  <message>
   <source>Fitted</source>
   <translation>Angepasst</translation>
  </message>
  <message>
   <source>Exporting</source>
   <translation>Export</translation>
  </message>
  <message>
   <source>Factoring</source>
   <translation>Faktorisierung</translation>
  </message>
  <message>
   <source>Blend</source>
   <translation>Mischung</translation>
  </message>
  <message>
   <source>Patches</source>
   <translation>Felder</translation>
  </message>
  <message>
   <source>Warp</source>
   <translation>Verzerrung</translation>
  </message>
  <message>
   <source>Shape</source>
   <translation>Form</translation>
  </message>
  <message>
   <source>Symmetry</source>
   <translation>Symmetrie</translation>
  </message>
  <message>
   <source>Circle</source>
   <translation>Kreis</translation>
  </message>
  <message>
   <source>Sources</source>
   <translation>Quellen</translation>
  </message>
  <message>
   <source>Unpacked</source>
   <translation>Entpackt</translation>
  </message>
  <message>
   <source>Quality</source>
   <translation>Qualität</translation>
  </message>
  <message>
   <source>Finding</source>
   <translation>Befund</translation>
  </message>
  <message>
   <source>Ceiling</source>
   <translation>Obergrenze</translation>
  </message>
  <message>
   <source>Mesh</source>
   <translation>Netz</translation>
  </message>
  <message>
   <source>Setting</source>
   <translation>Einstellung</translation>
  </message>
  <message>
   <source>Kernel</source>
   <translation>Kern</translation>
  </message>
  <message>
   <source>Storage</source>
   <translation>Ablage</translation>
  </message>
  <message>
   <source>Project</source>
   <translation>Projekt</translation>
  </message>
  <message>
   <source>is not between %1 and %2</source>
   <translation>liegt nicht zwischen %1 und %2</translation>
  </message>
  <message>
   <source>the parts of a %1 do not fit together</source>
   <translation>die Teile passen nicht zusammen: %1</translation>
  </message>
  <message>
   <source>image stack</source>
   <translation>Bildstapel</translation>
  </message>
  <message>
   <source>stack of photographs</source>
   <translation>Stapel von Fotos</translation>
  </message>
  <message>
   <source>list of photographs</source>
   <translation>Liste der Fotos</translation>
  </message>
  <message>
   <source>is none of %1</source>
   <translation>ist keines von %1</translation>
  </message>
  <message>
   <source>is not a mapping</source>
   <translation>ist keine Zuordnung</translation>
  </message>
  <message>
   <source>is not a set</source>
   <translation>ist keine Menge</translation>
  </message>
  <message>
   <source>is not a list</source>
   <translation>ist keine Liste</translation>
  </message>
  <message>
   <source>is not a value</source>
   <translation>ist kein Wert</translation>
  </message>
  <message>
   <source>is neither true nor false</source>
   <translation>ist weder wahr noch falsch</translation>
  </message>
  <message>
   <source>is not a whole number</source>
   <translation>ist keine ganze Zahl</translation>
  </message>
  <message>
   <source>is not a finite number</source>
   <translation>ist keine endliche Zahl</translation>
  </message>
  <message>
   <source>is not a number</source>
   <translation>ist keine Zahl</translation>
  </message>
  <message>
   <source>is not text</source>
   <translation>ist kein Text</translation>
  </message>
  <message>
   <source>is not a path</source>
   <translation>ist kein Pfad</translation>
  </message>
  <message>
   <source>is not a folder</source>
   <translation>ist kein Ordner</translation>
  </message>
  <message>
   <source>is not a valid %1</source>
   <translation>ist nicht gültig: %1</translation>
  </message>
  <message>
   <source>is not a list of values</source>
   <translation>ist keine Liste von Werten</translation>
  </message>
  <message>
   <source>has %1 values in place of %2</source>
   <translation>hat %1 Werte statt %2</translation>
  </message>
  <message>
   <source>has no names</source>
   <translation>hat keine Namen</translation>
  </message>
  <message>
   <source>is not an array</source>
   <translation>ist kein Feld</translation>
  </message>
  <message>
   <source>is an array of %1</source>
   <translation>ist ein Feld von %1</translation>
  </message>
  <message>
   <source>no axes</source>
   <translation>keine Achsen</translation>
  </message>
  <message>
   <source>holds numbers that are not finite</source>
   <translation>enthält Zahlen, die nicht endlich sind</translation>
  </message>
  <message>
   <source>looking for errors that were measured before</source>
   <translation>früher gemessene Fehler werden gesucht</translation>
  </message>
  <message>
   <source>The error is measured again when you ask for it</source>
   <translation>Der Fehler wird bei Bedarf neu gemessen</translation>
  </message>
  <message>
   <source>an import of photographs</source>
   <translation>ein Import von Fotos</translation>
  </message>
  <message>
   <source>imports of photographs</source>
   <translation>Importe von Fotos</translation>
  </message>
  <message>
   <source>a factor run</source>
   <translation>ein Faktorlauf</translation>
  </message>
  <message>
   <source>factor runs</source>
   <translation>Faktorläufe</translation>
  </message>
  <message>
   <source>a bake</source>
   <translation>eine Vorberechnung</translation>
  </message>
  <message>
   <source>Gone from the data folder: %1. Making that again takes about %2</source>
   <translation>Im Datenordner fehlt: %1. Neu erzeugen dauert etwa %2</translation>
  </message>
  <message>
   <source>looking at %1</source>
   <translation>%1 wird untersucht</translation>
  </message>
  <message>
   <source>Check its permissions</source>
   <translation>Seine Rechte prüfen</translation>
  </message>
  <message>
   <source>holds more than %1 files</source>
   <translation>enthält mehr als %1 Dateien</translation>
  </message>
  <message>
   <source>Choose the folder of the photographs</source>
   <translation>Den Ordner der Fotos wählen</translation>
  </message>
  <message>
   <source>%1 photographs, %2 among them, are</source>
   <translation>%1 Fotos, darunter %2, sind</translation>
  </message>
  <message>
   <source>it was when it was</source>
   <translation>beim</translation>
  </message>
  <message>
   <source>they were when they were</source>
   <translation>beim</translation>
  </message>
  <message>
   <source>%1 not as %2 imported</source>
   <translation>%1 nicht wie %2 Import</translation>
  </message>
  <message>
   <source>by %1, and %2 reads</source>
   <translation>mit %1, und %2 liest</translation>
  </message>
  <message>
   <source>and now they give</source>
   <translation>und jetzt ergeben sie</translation>
  </message>
  <message>
   <source>was imported %1 other values of its photographs</source>
   <translation>wurde importiert %1 andere Werte seiner Fotos</translation>
  </message>
  <message>
   <source>Import the photographs again</source>
   <translation>Die Fotos neu importieren</translation>
  </message>
  <message>
   <source>compressing the photographs</source>
   <translation>Fotos werden komprimiert</translation>
  </message>
  <message>
   <source>reading the photographs</source>
   <translation>Fotos werden gelesen</translation>
  </message>
  <message>
   <source>is damaged: it has %1 bytes, not %2</source>
   <translation>ist beschädigt: es hat %1 Bytes, nicht %2</translation>
  </message>
  <message>
   <source>unpacking the photographs</source>
   <translation>Fotos werden entpackt</translation>
  </message>
  <message>
   <source>Check its permissions and its disk</source>
   <translation>Seine Rechte und seinen Datenträger prüfen</translation>
  </message>
  <message>
   <source>Close it there</source>
   <translation>Dort schließen</translation>
  </message>
  <message>
   <source>data folder</source>
   <translation>Datenordner</translation>
  </message>
  <message>
   <source>its folder is gone</source>
   <translation>sein Ordner fehlt</translation>
  </message>
  <message>
   <source>Bring it back, or save the project elsewhere</source>
   <translation>Wiederherstellen oder das Projekt woanders speichern</translation>
  </message>
  <message>
   <source>it has a history, and no document</source>
   <translation>es hat einen Verlauf und kein Dokument</translation>
  </message>
  <message>
   <source>its position in the history is not a number</source>
   <translation>seine Stelle im Verlauf ist keine Zahl</translation>
  </message>
  <message>
   <source>state %1</source>
   <translation>Stand %1</translation>
  </message>
  <message>
   <source>a state of its history is gone</source>
   <translation>ein Stand seines Verlaufs fehlt</translation>
  </message>
  <message>
   <source>a state of its history is not a list of parts</source>
   <translation>ein Stand seines Verlaufs ist keine Liste von Teilen</translation>
  </message>
  <message>
   <source>no value of a project</source>
   <translation>kein Wert eines Projekts</translation>
  </message>
  <message>
   <source>part %1 %2</source>
   <translation>Teil %1 %2</translation>
  </message>
  <message>
   <source>project file</source>
   <translation>Projektdatei</translation>
  </message>
  <message>
   <source>a fault of the program (%1)</source>
   <translation>ein Fehler des Programms (%1)</translation>
  </message>
  <message>
   <source>reading what is sound</source>
   <translation>Unbeschädigtes wird gelesen</translation>
  </message>
  <message>
   <source>holds no document that could be saved</source>
   <translation>enthält kein Dokument, das gesichert werden könnte</translation>
  </message>
  <message>
   <source>Open a copy of the project</source>
   <translation>Eine Kopie des Projekts öffnen</translation>
  </message>
  <message>
   <source>holds nothing that can be read (%1)</source>
   <translation>enthält nichts Lesbares (%1)</translation>
  </message>
  <message>
   <source>Open a copy of it</source>
   <translation>Eine Kopie davon öffnen</translation>
  </message>
  <message>
   <source>the history is left behind</source>
   <translation>der Verlauf bleibt zurück</translation>
  </message>
  <message>
   <source>the history is left behind: one of its states %1</source>
   <translation>der Verlauf bleibt zurück: einer seiner Stände %1</translation>
  </message>
  <message>
   <source>the history cannot be read</source>
   <translation>der Verlauf lässt sich nicht lesen</translation>
  </message>
  <message>
   <source>the history cannot be read (%1)</source>
   <translation>der Verlauf lässt sich nicht lesen (%1)</translation>
  </message>
  <message>
   <source>has lost a state</source>
   <translation>hat einen Stand verloren</translation>
  </message>
  <message>
   <source>has no sound part</source>
   <translation>hat keinen unbeschädigten Teil</translation>
  </message>
  <message>
   <source>`lightarc project find %1 --photographs FOLDER` finds those that moved</source>
   <translation>„lightarc project find %1 --photographs ORDNER“ findet verschobene</translation>
  </message>
  <message>
   <source>%1 missing from %2; %3</source>
   <translation>%1 fehlt in %2; %3</translation>
  </message>
  <message>
   <source>it has no document</source>
   <translation>es hat kein Dokument</translation>
  </message>
  <message>
   <source>reading all states</source>
   <translation>alle Stände werden gelesen</translation>
  </message>
  <message>
   <source>step %1 (%2): %3</source>
   <translation>Schritt %1 (%2): %3</translation>
  </message>
  <message>
   <source>%1 can be made again: %2</source>
   <translation>%1 lässt sich neu erzeugen: %2</translation>
  </message>
  <message>
   <source>Open the project in the window and make it again, or bring back %1</source>
   <translation>Das Projekt im Fenster öffnen und neu erzeugen oder %1 zurückbringen</translation>
  </message>
  <message>
   <source>has lost its %1 with its data folder</source>
   <translation>hat %1 mit seinem Datenordner verloren</translation>
  </message>
  <message>
   <source>making a small image</source>
   <translation>kleines Bild wird erzeugt</translation>
  </message>
  <message>
   <source>renaming %1</source>
   <translation>%1 wird umbenannt</translation>
  </message>
  <message>
   <source>cannot be the name of a project</source>
   <translation>kann nicht der Name eines Projekts sein</translation>
  </message>
  <message>
   <source>Choose a name without slashes</source>
   <translation>Einen Namen ohne Schrägstriche wählen</translation>
  </message>
  <message>
   <source>Choose another name</source>
   <translation>Einen anderen Namen wählen</translation>
  </message>
  <message>
   <source>moving %1 to the trash</source>
   <translation>%1 kommt in den Papierkorb</translation>
  </message>
  <message>
   <source>Remove %1 and %2 in your file manager</source>
   <translation>%1 und %2 im Dateimanager entfernen</translation>
  </message>
  <message>
   <source>cannot be moved to the trash of this system</source>
   <translation>lässt sich nicht in den Papierkorb dieses Systems legen</translation>
  </message>
  <message>
   <source>is no longer there</source>
   <translation>ist nicht mehr da</translation>
  </message>
  <message>
   <source>Look for it in your file manager</source>
   <translation>Im Dateimanager danach suchen</translation>
  </message>
  <message>
   <source>Close it there first</source>
   <translation>Zuerst dort schließen</translation>
  </message>
  <message>
   <source>stack %1</source>
   <translation>Stapel %1</translation>
  </message>
 </context>
 <context>
  <name>session</name>
  <message>
   <source>some 10 s while nothing else runs</source>
   <translation>etwa 10 s, während nichts anderes läuft</translation>
  </message>
 </context>
 <context>
  <name>engine/core</name>
  <message>
   <source>%1 of memory are too little; %2 are the least</source>
   <translation>%1 Speicher sind zu wenig; mindestens nötig sind %2</translation>
  </message>
  <message>
   <source>Parameters</source>
   <translation>Parameter</translation>
  </message>
  <message>
   <source>%1 is not an address of a Dask scheduler such as tls://192.168.0.10:8786</source>
   <translation>%1 ist keine Adresse eines Dask-Schedulers wie tls://192.168.0.10:8786</translation>
  </message>
  <message>
   <source>%1 has no TLS, so that anybody in the network could run code on this computer: use a tls:// address, or add --plain-cluster in a network of your own</source>
   <translation>%1 hat kein TLS, sodass jeder im Netz Programme auf diesem Rechner ausführen könnte: eine tls://-Adresse verwenden oder in einem eigenen Netz --plain-cluster hinzufügen</translation>
  </message>
  <message>
   <source>Install it with: pip install distributed</source>
   <translation>So installieren: pip install distributed</translation>
  </message>
  <message>
   <source>%1 on a cluster needs the library distributed</source>
   <translation>%1 auf einem Cluster braucht die Bibliothek distributed</translation>
  </message>
  <message>
   <source>no scheduler of a cluster answers there (%1)</source>
   <translation>dort antwortet kein Scheduler eines Clusters (%1)</translation>
  </message>
  <message>
   <source>Start one with: dask scheduler, and workers with: dask worker ADDRESS; or leave --cluster out</source>
   <translation>Einen starten mit: dask scheduler, und Worker mit: dask worker ADDRESS; oder --cluster weglassen</translation>
  </message>
  <message>
   <source>the cluster has no workers</source>
   <translation>der Cluster hat keine Worker</translation>
  </message>
  <message>
   <source>Start some with: dask worker %1</source>
   <translation>Welche starten mit: dask worker %1</translation>
  </message>
  <message>
   <source>Planning</source>
   <translation>Planung</translation>
  </message>
  <message>
   <source>linear Rec.709</source>
   <translation>lineares Rec.709</translation>
  </message>
  <message>
   <source>linear Rec.2020</source>
   <translation>lineares Rec.2020</translation>
  </message>
  <message>
   <source>Close other programs, ask for fewer pixels, texels or vertices, or raise the limits of this account (ulimit -v, ulimit -u, ulimit -n)</source>
   <translation>Andere Programme schließen, weniger Pixel, Texel oder Eckpunkte verlangen oder die Grenzen dieses Kontos erhöhen (ulimit -v, ulimit -u, ulimit -n)</translation>
  </message>
  <message>
   <source>failed to map segment</source>
   <translation>Segment ließ sich nicht abbilden</translation>
  </message>
  <message>
   <source>cannot allocate memory</source>
   <translation>Speicher ließ sich nicht belegen</translation>
  </message>
  <message>
   <source>cannot map zero-fill</source>
   <translation>nullgefüllter Speicher ließ sich nicht abbilden</translation>
  </message>
  <message>
   <source>Check that it is there and its permissions</source>
   <translation>Prüfen, ob es da ist, und seine Rechte</translation>
  </message>
  <message>
   <source>: %1 MiB more were needed</source>
   <translation>: %1 MiB mehr wären nötig</translation>
  </message>
  <message>
   <source>There is not enough memory%1</source>
   <translation>Der Speicher reicht nicht%1</translation>
  </message>
  <message>
   <source>There is not enough memory</source>
   <translation>Der Speicher reicht nicht</translation>
  </message>
  <message>
   <source>Too many files are open</source>
   <translation>Zu viele Dateien sind geöffnet</translation>
  </message>
  <message>
   <source>No further process can be started</source>
   <translation>Kein weiterer Prozess lässt sich starten</translation>
  </message>
  <message>
   <source>There is not enough memory to load all libraries</source>
   <translation>Der Speicher reicht nicht, um alle Bibliotheken zu laden</translation>
  </message>
  <message>
   <source>up to %1</source>
   <translation>bis zu %1</translation>
  </message>
  <message>
   <source>and %1 more%2</source>
   <translation>und %1 weitere%2</translation>
  </message>
  <message>
   <source>%1 is on or off, not %2</source>
   <translation>%1 ist an oder aus, nicht %2</translation>
  </message>
  <message>
   <source>%1 is %2, not %3</source>
   <translation>%1 ist %2, nicht %3</translation>
  </message>
  <message>
   <source>%1 is a text, not %2</source>
   <translation>%1 ist ein Text, nicht %2</translation>
  </message>
  <message>
   <source>%1 are texts, not %2</source>
   <translation>%1 sind Texte, nicht %2</translation>
  </message>
  <message>
   <source>%1 is a number, not %2</source>
   <translation>%1 ist eine Zahl, nicht %2</translation>
  </message>
  <message>
   <source>%1 is a whole number, not %2</source>
   <translation>%1 ist eine ganze Zahl, nicht %2</translation>
  </message>
  <message>
   <source>%1 %2 is outside %3 … %4</source>
   <translation>%1: %2 liegt nicht zwischen %3 und %4</translation>
  </message>
  <message>
   <source>%1 %2 is not possible; %3 are</source>
   <translation>%1: %2 ist nicht möglich; möglich sind %3</translation>
  </message>
  <message>
   <source>one number or three</source>
   <translation>eine Zahl oder drei</translation>
  </message>
  <message>
   <source>a number</source>
   <translation>eine Zahl</translation>
  </message>
  <message>
   <source>%1 needs %2, got %3</source>
   <translation>%1 braucht %2, nicht %3</translation>
  </message>
  <message>
   <source>%1 needs one number or three, got %2</source>
   <translation>%1 braucht eine Zahl oder drei, nicht %2</translation>
  </message>
  <message>
   <source>%1 = %2 is outside [%3, %4]%5</source>
   <translation>%1 = %2 liegt außerhalb von [%3, %4]%5</translation>
  </message>
  <message>
   <source>%1 needs a value, as %2=%3</source>
   <translation>%1 braucht einen Wert, etwa %2=%3</translation>
  </message>
  <message>
   <source>unknown parameter %1%2; choose from %3</source>
   <translation>unbekannter Parameter %1%2; möglich: %3</translation>
  </message>
  <message>
   <source>%1 is given twice</source>
   <translation>%1 ist doppelt angegeben</translation>
  </message>
  <message>
   <source>%1 = %2 is not a number</source>
   <translation>%1 = %2 ist keine Zahl</translation>
  </message>
  <message>
   <source>%1 = %2 needs %3</source>
   <translation>%1 = %2 braucht %3</translation>
  </message>
  <message>
   <source>one number or r/g/b</source>
   <translation>eine Zahl oder r/g/b</translation>
  </message>
  <message>
   <source>one number</source>
   <translation>eine Zahl</translation>
  </message>
  <message>
   <source>%1 s left</source>
   <translation>noch %1 s</translation>
  </message>
  <message>
   <source>%1 min left</source>
   <translation>noch %1 min</translation>
  </message>
  <message>
   <source> (did you mean %1?)</source>
   <translation> (gemeint: %1?)</translation>
  </message>
 </context>
 <context>
  <name>engine/storage</name>
  <message>
   <source>Thumbs.db</source>
   <translation>Thumbs.db</translation>
  </message>
  <message>
   <source>Ask for the bundle again from where it came</source>
   <translation>Das Paket noch einmal anfordern</translation>
  </message>
  <message>
   <source>%1 has %2 bytes, more than %3</source>
   <translation>%1 hat %2 Bytes, mehr als %3</translation>
  </message>
  <message>
   <source>has no member %1</source>
   <translation>hat keinen Teil %1</translation>
  </message>
  <message>
   <source>Export the bundle again</source>
   <translation>Das Paket neu exportieren</translation>
  </message>
  <message>
   <source>Check that it exists and may be read</source>
   <translation>Prüfen, ob es existiert und gelesen werden darf</translation>
  </message>
  <message>
   <source>%1 is not a regular file</source>
   <translation>%1 ist keine gewöhnliche Datei</translation>
  </message>
  <message>
   <source>Choose a bundle</source>
   <translation>Ein Paket wählen</translation>
  </message>
  <message>
   <source>Choose a .lightarc file or a bundle folder</source>
   <translation>Eine .lightarc-Datei oder den Ordner eines Pakets wählen</translation>
  </message>
  <message>
   <source>holds %1 twice</source>
   <translation>enthält %1 zweimal</translation>
  </message>
  <message>
   <source>would unpack to more than %1 times its size</source>
   <translation>würde auf mehr als das %1-Fache seiner Größe entpackt</translation>
  </message>
  <message>
   <source>holds a member with an impossible name, %1</source>
   <translation>enthält einen Teil mit einem unmöglichen Namen, %1</translation>
  </message>
  <message>
   <source>%1 is encrypted</source>
   <translation>%1 ist verschlüsselt</translation>
  </message>
  <message>
   <source>Ask for it without a password</source>
   <translation>Ohne Passwort anfordern</translation>
  </message>
  <message>
   <source>%1 is packed by an unknown method</source>
   <translation>%1 ist mit einem unbekannten Verfahren gepackt</translation>
  </message>
  <message>
   <source>Pack it with deflate or not at all</source>
   <translation>Mit deflate oder gar nicht packen</translation>
  </message>
  <message>
   <source>%1 would unpack to more than %2 times its size</source>
   <translation>%1 würde auf mehr als das %2-Fache seiner Größe entpackt</translation>
  </message>
  <message>
   <source>holds what no bundle holds: %1%2</source>
   <translation>enthält, was kein Paket enthält: %1%2</translation>
  </message>
  <message>
   <source>would unpack to more than %1 GiB</source>
   <translation>würde auf mehr als %1 GiB entpackt</translation>
  </message>
  <message>
   <source>%1 in it is damaged (%2)</source>
   <translation>%1 darin ist beschädigt (%2)</translation>
  </message>
  <message>
   <source>%1 in it is damaged (its size is not the declared one)</source>
   <translation>%1 darin ist beschädigt (die Größe ist nicht die angegebene)</translation>
  </message>
  <message>
   <source>Ask for it again from where it came</source>
   <translation>Fordern Sie die Datei dort neu an, woher sie kam</translation>
  </message>
  <message>
   <source>is a damaged zip archive (%1)</source>
   <translation>ist ein beschädigtes ZIP-Archiv (%1)</translation>
  </message>
  <message>
   <source>is cut short or has data after its end</source>
   <translation>ist abgeschnitten oder hat Daten hinter seinem Ende</translation>
  </message>
  <message>
   <source>is not a zip archive</source>
   <translation>ist kein ZIP-Archiv</translation>
  </message>
  <message>
   <source>is a damaged zip archive (no 64-bit end record)</source>
   <translation>ist ein beschädigtes ZIP-Archiv (kein 64-Bit-Endeintrag)</translation>
  </message>
  <message>
   <source>lists %1 members in %2 bytes, more than an archive may</source>
   <translation>nennt %1 Teile in %2 Bytes, mehr als ein Archiv darf</translation>
  </message>
  <message>
   <source>is a damaged zip archive (its end record does not fit its length)</source>
   <translation>ist ein beschädigtes ZIP-Archiv (sein Endeintrag passt nicht zur Länge)</translation>
  </message>
  <message>
   <source>a header of %1 bytes</source>
   <translation>ein Kopf von %1 Bytes</translation>
  </message>
  <message>
   <source>lists more than %1 members</source>
   <translation>nennt mehr als %1 Teile</translation>
  </message>
  <message>
   <source>is not a tar archive, or a damaged one (%1)</source>
   <translation>ist kein oder ein beschädigtes TAR-Archiv (%1)</translation>
  </message>
  <message>
   <source>is cut short or damaged: its list of members has no end</source>
   <translation>ist abgeschnitten oder beschädigt: die Liste seiner Teile hat kein Ende</translation>
  </message>
  <message>
   <source>Free some space, or unpack it yourself and give the folder</source>
   <translation>Platz schaffen, oder selbst entpacken und den Ordner angeben</translation>
  </message>
  <message>
   <source>cannot be unpacked (%1)</source>
   <translation>lässt sich nicht entpacken (%1)</translation>
  </message>
  <message>
   <source>is cut short</source>
   <translation>ist abgeschnitten</translation>
  </message>
  <message>
   <source>%1… (%2 characters)</source>
   <translation>%1… (%2 Zeichen)</translation>
  </message>
  <message>
   <source>your disk quota is used up</source>
   <translation>das Kontingent auf dem Datenträger ist aufgebraucht</translation>
  </message>
  <message>
   <source>the file is larger than this file system or account allows</source>
   <translation>die Datei ist größer, als dieses Dateisystem oder Konto erlaubt</translation>
  </message>
  <message>
   <source>Choose another disk</source>
   <translation>Einen anderen Datenträger wählen</translation>
  </message>
  <message>
   <source>the file system is read-only</source>
   <translation>das Dateisystem ist schreibgeschützt</translation>
  </message>
  <message>
   <source>Choose a folder on another disk</source>
   <translation>Einen Ordner auf einem anderen Datenträger wählen</translation>
  </message>
  <message>
   <source>too many files are open</source>
   <translation>zu viele Dateien sind geöffnet</translation>
  </message>
  <message>
   <source>Close other files or programs and try again</source>
   <translation>Andere Dateien oder Programme schließen und noch einmal versuchen</translation>
  </message>
  <message>
   <source>the disk reported an error</source>
   <translation>der Datenträger meldete einen Fehler</translation>
  </message>
  <message>
   <source>Check the disk, or choose another one</source>
   <translation>Den Datenträger prüfen oder einen anderen wählen</translation>
  </message>
  <message>
   <source>the name is too long</source>
   <translation>der Name ist zu lang</translation>
  </message>
  <message>
   <source>Choose a shorter name</source>
   <translation>Einen kürzeren Namen wählen</translation>
  </message>
  <message>
   <source>the folder does not exist</source>
   <translation>der Ordner existiert nicht</translation>
  </message>
  <message>
   <source>Create it first or choose another one</source>
   <translation>Ihn zuerst anlegen oder einen anderen wählen</translation>
  </message>
  <message>
   <source>a part of the path is not a folder</source>
   <translation>ein Teil des Pfads ist kein Ordner</translation>
  </message>
  <message>
   <source>Choose another path</source>
   <translation>Einen anderen Pfad wählen</translation>
  </message>
  <message>
   <source>it is a folder</source>
   <translation>es ist ein Ordner</translation>
  </message>
  <message>
   <source>Name a file</source>
   <translation>Eine Datei nennen</translation>
  </message>
  <message>
   <source>its symbolic links lead in a circle</source>
   <translation>symbolische Links führen im Kreis</translation>
  </message>
  <message>
   <source>it is in use by the system</source>
   <translation>es wird vom System benutzt</translation>
  </message>
  <message>
   <source>it is not a regular file</source>
   <translation>es ist keine gewöhnliche Datei</translation>
  </message>
  <message>
   <source>the file is write-protected</source>
   <translation>die Datei ist schreibgeschützt</translation>
  </message>
  <message>
   <source>Choose another name or change its permissions</source>
   <translation>Einen anderen Namen wählen oder die Rechte ändern</translation>
  </message>
  <message>
   <source>a file of that name exists</source>
   <translation>eine Datei dieses Namens existiert</translation>
  </message>
  <message>
   <source>Choose another name for the folder</source>
   <translation>Einen anderen Namen für den Ordner wählen</translation>
  </message>
  <message>
   <source>the folder exists and holds no %1, so it is not ours</source>
   <translation>der Ordner existiert und enthält kein %1, gehört also nicht Lightarc</translation>
  </message>
  <message>
   <source>another run is writing it</source>
   <translation>ein anderer Lauf schreibt sie</translation>
  </message>
  <message>
   <source>Wait for that run or choose another name</source>
   <translation>Auf diesen Lauf warten oder einen anderen Namen wählen</translation>
  </message>
  <message>
   <source>the name holds characters that no file name can hold</source>
   <translation>der Name enthält Zeichen, die kein Dateiname haben kann</translation>
  </message>
  <message>
   <source>Choose another</source>
   <translation>Einen anderen wählen</translation>
  </message>
  <message>
   <source>it is the root of the file system</source>
   <translation>es ist die Wurzel des Dateisystems</translation>
  </message>
  <message>
   <source>%1 needed, </source>
   <translation>%1 nötig, </translation>
  </message>
  <message>
   <source>%1 (%2%3 free)</source>
   <translation>%1 (%2%3 frei)</translation>
  </message>
  <message>
   <source>%1 bytes</source>
   <translation>%1 Bytes</translation>
  </message>
  <message>
   <source>names an impossible file (%1)</source>
   <translation>nennt eine unmögliche Datei (%1)</translation>
  </message>
  <message>
   <source>names a file outside its folder (%1)</source>
   <translation>nennt eine Datei außerhalb seines Ordners (%1)</translation>
  </message>
  <message>
   <source>needs the file %1 next to it, which %2</source>
   <translation>braucht die Datei %1 neben sich; sie %2</translation>
  </message>
  <message>
   <source>needs more than %1 GiB to decode</source>
   <translation>braucht zum Dekodieren mehr als %1 GiB</translation>
  </message>
  <message>
   <source>Make it smaller</source>
   <translation>Verkleinern</translation>
  </message>
  <message>
   <source>is damaged or of an unknown kind%1</source>
   <translation>ist beschädigt oder von unbekannter Art%1</translation>
  </message>
  <message>
   <source>cannot be unpacked: %1</source>
   <translation>lässt sich nicht entpacken: %1</translation>
  </message>
  <message>
   <source>Free some space on the disk of temporary files</source>
   <translation>Platz auf dem Datenträger für temporäre Dateien schaffen</translation>
  </message>
  <message>
   <source>cannot be read: %1</source>
   <translation>lässt sich nicht lesen: %1</translation>
  </message>
  <message>
   <source>cannot be decoded (%1)</source>
   <translation>lässt sich nicht dekodieren (%1)</translation>
  </message>
  <message>
   <source>Check the disk that it lies on, and open it again</source>
   <translation>Den Datenträger prüfen, auf dem es liegt, und noch einmal öffnen</translation>
  </message>
  <message>
   <source>It is made again from its sources</source>
   <translation>Es wird aus seinen Quellen neu erzeugt</translation>
  </message>
  <message>
   <source>planes and rows are chosen without an ellipsis or new axes</source>
   <translation>Ebenen und Zeilen werden ohne Auslassung und ohne neue Achsen gewählt</translation>
  </message>
  <message>
   <source>rows are read downwards</source>
   <translation>Zeilen werden abwärts gelesen</translation>
  </message>
  <message>
   <source>is not there at the moment</source>
   <translation>ist im Moment nicht da</translation>
  </message>
  <message>
   <source>cannot be read any more (%1)</source>
   <translation>lässt sich nicht mehr lesen (%1)</translation>
  </message>
  <message>
   <source>was replaced by another file while it was open</source>
   <translation>wurde, während es geöffnet war, durch eine andere Datei ersetzt</translation>
  </message>
  <message>
   <source>Open the new one</source>
   <translation>Die neue öffnen</translation>
  </message>
  <message>
   <source>is damaged</source>
   <translation>ist beschädigt</translation>
  </message>
  <message>
   <source>was cut short while it was open</source>
   <translation>wurde abgeschnitten, während es geöffnet war</translation>
  </message>
  <message>
   <source>the name of the output is empty</source>
   <translation>der Name der Ausgabe ist leer</translation>
  </message>
  <message>
   <source>Name %1</source>
   <translation>%1 nennen</translation>
  </message>
  <message>
   <source>no name can hold such a character</source>
   <translation>kein Name kann ein solches Zeichen enthalten</translation>
  </message>
  <message>
   <source>%1 has the ending of a file, and %2 is a folder</source>
   <translation>%1 hat die Endung einer Datei, und %2 ist ein Ordner</translation>
  </message>
  <message>
   <source>%1 must end in %2, as the name of %3</source>
   <translation>%1 muss auf %2 enden, als Name für %3</translation>
  </message>
  <message>
   <source>it names a folder, and %1 is a file</source>
   <translation>es nennt einen Ordner, und %1 ist eine Datei</translation>
  </message>
  <message>
   <source>Leave the slash at its end out</source>
   <translation>Den Schrägstrich am Ende weglassen</translation>
  </message>
  <message>
   <source>it is read by this command</source>
   <translation>es wird von diesem Befehl gelesen</translation>
  </message>
  <message>
   <source>it is the same as, or part of, %1, which is read</source>
   <translation>es ist dasselbe wie %1 oder ein Teil davon, das gelesen wird</translation>
  </message>
  <message>
   <source>%1, and an output never replaces an input</source>
   <translation>%1, und eine Ausgabe ersetzt nie eine Eingabe</translation>
  </message>
  <message>
   <source>it lies in %1, which is read by this command</source>
   <translation>es liegt in %1, das von diesem Befehl gelesen wird</translation>
  </message>
  <message>
   <source>Choose a place outside that folder</source>
   <translation>Einen Ort außerhalb dieses Ordners wählen</translation>
  </message>
  <message>
   <source>the folder holds %1, which is read, and would be replaced</source>
   <translation>der Ordner enthält %1, das gelesen wird und ersetzt würde</translation>
  </message>
  <message>
   <source>it is, or lies in, %1, which is another output of this command</source>
   <translation>es ist oder liegt in %1, einer anderen Ausgabe dieses Befehls</translation>
  </message>
  <message>
   <source>Choose another name for one of them</source>
   <translation>Für eines davon einen anderen Namen wählen</translation>
  </message>
  <message>
   <source>it cannot be looked at (%1)</source>
   <translation>es lässt sich nicht untersuchen (%1)</translation>
  </message>
  <message>
   <source>Name a file for %1</source>
   <translation>Eine Datei für %1 nennen</translation>
  </message>
  <message>
   <source>it exists, and is not %1 that this command wrote</source>
   <translation>es existiert und ist nicht %1 dieses Befehls</translation>
  </message>
  <message>
   <source>Choose another name, or add --overwrite to replace it</source>
   <translation>Einen anderen Namen wählen oder mit --overwrite ersetzen</translation>
  </message>
  <message>
   <source>the folder exists and is not %1</source>
   <translation>der Ordner existiert und ist nicht %1</translation>
  </message>
  <message>
   <source>the folder would be replaced, and holds %1, which is no part of %2</source>
   <translation>der Ordner würde ersetzt und enthält %1, das kein Teil ist von: %2</translation>
  </message>
  <message>
   <source>Move that elsewhere, or choose another name</source>
   <translation>Das verschieben oder einen anderen Namen wählen</translation>
  </message>
  <message>
   <source>%1 is a file, and would have to be a folder</source>
   <translation>%1 ist eine Datei und müsste ein Ordner sein</translation>
  </message>
  <message>
   <source>it does not begin as packed data do</source>
   <translation>es beginnt nicht wie gepackte Daten</translation>
  </message>
  <message>
   <source>it declares %1 bytes, more than %2</source>
   <translation>es gibt %1 Bytes an, mehr als %2</translation>
  </message>
  <message>
   <source>it is cut short</source>
   <translation>es ist abgeschnitten</translation>
  </message>
  <message>
   <source>its parts do not fit its length</source>
   <translation>seine Teile passen nicht zu seiner Länge</translation>
  </message>
  <message>
   <source>a part of it is not as it was written</source>
   <translation>ein Teil davon ist nicht, wie er geschrieben wurde</translation>
  </message>
  <message>
   <source>Targa</source>
   <translation>Targa</translation>
  </message>
  <message>
   <source>GLSL of BRDF Explorer (.brdf)</source>
   <translation>GLSL von BRDF Explorer (.brdf)</translation>
  </message>
  <message>
   <source>RGL (.bsdf)</source>
   <translation>RGL (.bsdf)</translation>
  </message>
  <message>
   <source>tables of this program (.exr)</source>
   <translation>Tabellen dieses Programms (.exr)</translation>
  </message>
  <message>
   <source>MERL (.binary)</source>
   <translation>MERL (.binary)</translation>
  </message>
  <message>
   <source>UTIA (.bin)</source>
   <translation>UTIA (.bin)</translation>
  </message>
  <message>
   <source>Cornell and ASTM E1392 (.brdf, .astm)</source>
   <translation>Cornell und ASTM E1392 (.brdf, .astm)</translation>
  </message>
  <message>
   <source>ALTA text (.dat)</source>
   <translation>ALTA-Text (.dat)</translation>
  </message>
  <message>
   <source>CUReT (rbrdf.dat …)</source>
   <translation>CUReT (rbrdf.dat …)</translation>
  </message>
  <message>
   <source>tables of angles and colours (.csv)</source>
   <translation>Tabellen von Winkeln und Farben (.csv)</translation>
  </message>
  <message>
   <source>linear sRGB, 1 = white level of the photographs</source>
   <translation>lineares sRGB, 1 = Weißpegel der Fotos</translation>
  </message>
  <message>
   <source>mean luminance of a photograph, radiance; r = sigma * f_r * cos(theta_i)</source>
   <translation>mittlere Leuchtdichte eines Fotos, Strahldichte; r = sigma * f_r * cos(theta_i)</translation>
  </message>
  <message>
   <source>1/sr, the cosine is not included</source>
   <translation>1/sr, ohne den Kosinus</translation>
  </message>
  <message>
   <source>degrees above the sample plane</source>
   <translation>Grad über der Ebene der Probe</translation>
  </message>
  <message>
   <source>row 0 on top, texel centres at half-integers</source>
   <translation>Zeile 0 oben, Mitten der Texel bei halben Zahlen</translation>
  </message>
  <message>
   <source>manifest.json is not the manifest of a Lightarc bundle</source>
   <translation>manifest.json ist nicht das Manifest eines Lightarc-Pakets</translation>
  </message>
  <message>
   <source>was written by a newer Lightarc (schema %1, this one reads %2)</source>
   <translation>wurde von einem neueren Lightarc geschrieben (Schema %1, dieses liest %2)</translation>
  </message>
  <message>
   <source>manifest.json is nested too deeply</source>
   <translation>manifest.json ist zu tief verschachtelt</translation>
  </message>
  <message>
   <source>manifest.json is not as it was written</source>
   <translation>manifest.json ist nicht, wie es geschrieben wurde</translation>
  </message>
  <message>
   <source>manifest.json: %1: %2</source>
   <translation>manifest.json: %1: %2</translation>
  </message>
  <message>
   <source>Remove it</source>
   <translation>Entfernen</translation>
  </message>
  <message>
   <source>(Landlock %1, seccomp%2)</source>
   <translation>(Landlock %1, seccomp%2)</translation>
  </message>
  <message>
   <source>, a root of its own</source>
   <translation>, ein eigenes Wurzelverzeichnis</translation>
  </message>
  <message>
   <source>, but could ask whether a file exists: this system grants no namespaces</source>
   <translation>, könnte aber fragen, ob eine Datei existiert: dieses System gewährt keine Namensräume</translation>
  </message>
  <message>
   <source>Files are decoded in a process that opens no other file, no network and no program %1%2</source>
   <translation>Dateien werden in einem Prozess dekodiert, der keine andere Datei, kein Netz und kein Programm öffnet %1%2</translation>
  </message>
  <message>
   <source>Files are decoded in a process that writes no file and opens no network and no program (seccomp), but could read other files: this kernel has no Landlock</source>
   <translation>Dateien werden in einem Prozess dekodiert, der keine Datei schreibt und weder Netz noch Programm öffnet (seccomp), aber andere Dateien lesen könnte: dieser Kernel hat kein Landlock</translation>
  </message>
  <message>
   <source>Files are decoded in a process that opens no other file and no program (Landlock %1), but could open a network: this kernel or CPU has no seccomp filter</source>
   <translation>Dateien werden in einem Prozess dekodiert, der keine andere Datei und kein Programm öffnet (Landlock %1), aber ein Netz öffnen könnte: dieser Kernel oder diese CPU hat keinen seccomp-Filter</translation>
  </message>
  <message>
   <source>Files are decoded in a process of its own, which this system does not confine further</source>
   <translation>Dateien werden in einem eigenen Prozess dekodiert, den dieses System nicht weiter einschränkt</translation>
  </message>
  <message>
   <source>a link would lie outside the new root</source>
   <translation>ein Link läge außerhalb des neuen Wurzelverzeichnisses</translation>
  </message>
  <message>
   <source>the system refuses a root of its own</source>
   <translation>das System verweigert ein eigenes Wurzelverzeichnis</translation>
  </message>
  <message>
   <source>, %1 are free</source>
   <translation>, %1 sind frei</translation>
  </message>
  <message>
   <source>there is no room for %1 of intermediate results (%2%3)</source>
   <translation>für %1 an Zwischenergebnissen ist kein Platz (%2%3)</translation>
  </message>
  <message>
   <source>Free some space or reduce the resolution</source>
   <translation>Platz schaffen oder die Auflösung verringern</translation>
  </message>
  <message>
   <source>giving pages back</source>
   <translation>Speicherseiten werden zurückgegeben</translation>
  </message>
  <message>
   <source>%1 is nested too deeply</source>
   <translation>%1 ist zu tief verschachtelt</translation>
  </message>
  <message>
   <source>%1 is not valid JSON (%2)</source>
   <translation>%1 ist kein gültiges JSON (%2)</translation>
  </message>
  <message>
   <source>Copy it again from where it came, or unpack it yourself and give the folder</source>
   <translation>Noch einmal von der Quelle kopieren, oder selbst entpacken und den Ordner angeben</translation>
  </message>
  <message>
   <source>is a %1 archive, which is not read</source>
   <translation>ist ein %1-Archiv, das nicht gelesen wird</translation>
  </message>
  <message>
   <source>Unpack it, or pack it as zip</source>
   <translation>Entpacken oder als ZIP packen</translation>
  </message>
  <message>
   <source>Unpacking %1 of %2</source>
   <translation>%1 von %2 wird entpackt</translation>
  </message>
  <message>
   <source>Unpacking</source>
   <translation>Entpacken</translation>
  </message>
  <message>
   <source>cannot be written (%1)</source>
   <translation>lässt sich nicht schreiben (%1)</translation>
  </message>
  <message>
   <source>Unpack it yourself and give the folder</source>
   <translation>Selbst entpacken und den Ordner angeben</translation>
  </message>
  <message>
   <source>holds both %1 and %2</source>
   <translation>enthält sowohl %1 als auch %2</translation>
  </message>
  <message>
   <source>%1 in it is damaged (it is cut short)</source>
   <translation>%1 darin ist beschädigt (abgeschnitten)</translation>
  </message>
  <message>
   <source>Unpacking %1</source>
   <translation>%1 wird entpackt</translation>
  </message>
  <message>
   <source>Check that the file exists and may be read</source>
   <translation>Prüfen, ob die Datei existiert und gelesen werden darf</translation>
  </message>
  <message>
   <source>Copy or download it again, or export it again from the program that wrote it</source>
   <translation>Neu kopieren oder herunterladen oder aus dem Ursprungsprogramm neu exportieren</translation>
  </message>
  <message>
   <source>is damaged: its decoder returned an invalid response</source>
   <translation>ist beschädigt: sein Dekodierer gab eine ungültige Antwort</translation>
  </message>
  <message>
   <source>is not a possible file name (%1)</source>
   <translation>ist kein möglicher Dateiname (%1)</translation>
  </message>
  <message>
   <source>Rename the file</source>
   <translation>Die Datei umbenennen</translation>
  </message>
  <message>
   <source>is a git-lfs pointer, not the data</source>
   <translation>ist ein git-lfs-Verweis, nicht die Daten</translation>
  </message>
  <message>
   <source>Fetch the data with `git lfs pull`</source>
   <translation>Die Daten mit „git lfs pull“ holen</translation>
  </message>
  <message>
   <source>changed while it was being read</source>
   <translation>änderte sich beim Lesen</translation>
  </message>
  <message>
   <source>Wait until it is complete and try again</source>
   <translation>Warten, bis es vollständig ist, und erneut versuchen</translation>
  </message>
  <message>
   <source>a folder</source>
   <translation>ein Ordner</translation>
  </message>
  <message>
   <source>a named pipe</source>
   <translation>eine benannte Pipe</translation>
  </message>
  <message>
   <source>a device</source>
   <translation>ein Gerät</translation>
  </message>
  <message>
   <source>a socket</source>
   <translation>ein Socket</translation>
  </message>
  <message>
   <source>is %1, not a regular file</source>
   <translation>ist %1, keine gewöhnliche Datei</translation>
  </message>
  <message>
   <source>Give a file</source>
   <translation>Eine Datei angeben</translation>
  </message>
  <message>
   <source>is empty (0 bytes)</source>
   <translation>ist leer (0 Bytes)</translation>
  </message>
  <message>
   <source>has %1, more than the limit of %2</source>
   <translation>hat %1, mehr als die Grenze von %2</translation>
  </message>
  <message>
   <source>cannot be decoded: the decoder process ends at once</source>
   <translation>lässt sich nicht dekodieren: der Dekodierprozess endet sofort</translation>
  </message>
  <message>
   <source>Start the program again</source>
   <translation>Das Programm neu starten</translation>
  </message>
  <message>
   <source>could not be decoded, because the decoder process did not start within %1 s</source>
   <translation>ließ sich nicht dekodieren, weil der Dekodierprozess nicht innerhalb von %1 s startete</translation>
  </message>
  <message>
   <source>Try again when other programs leave this machine more time</source>
   <translation>Noch einmal versuchen, wenn andere Programme diesem Rechner mehr Zeit lassen</translation>
  </message>
  <message>
   <source>could not be decoded within %1 s</source>
   <translation>ließ sich nicht innerhalb von %1 s dekodieren</translation>
  </message>
  <message>
   <source>could not be decoded, because the system ended the decoder process, as it does without memory</source>
   <translation>ließ sich nicht dekodieren, weil das System den Dekodierprozess beendete, wie es bei Speichermangel geschieht</translation>
  </message>
  <message>
   <source>Close other programs and try again</source>
   <translation>Andere Programme schließen und noch einmal versuchen</translation>
  </message>
  <message>
   <source>is damaged: its decoder crashed (exit code %1)</source>
   <translation>ist beschädigt: sein Dekodierer stürzte ab (Exit-Code %1)</translation>
  </message>
  <message>
   <source>decoder limit</source>
   <translation>Grenze des Dekodierers</translation>
  </message>
 </context>
 <context>
  <name>engine/images</name>
  <message>
   <source>a film is an .mp4, a .webp or a folder of PNG, not a %1 file</source>
   <translation>ein Film ist ein .mp4, ein .webp oder ein Ordner mit PNG, keine %1-Datei</translation>
  </message>
  <message>
   <source>a film of %1 × %2 pixels is not possible (2 … %3)</source>
   <translation>ein Film von %1 × %2 Pixeln ist nicht möglich (2 … %3)</translation>
  </message>
  <message>
   <source>no frame was written</source>
   <translation>kein Bild wurde geschrieben</translation>
  </message>
  <message>
   <source>Choose another name or kind of film</source>
   <translation>Einen anderen Namen oder eine andere Art von Film wählen</translation>
  </message>
  <message>
   <source>VP9 cannot be encoded here</source>
   <translation>VP9 lässt sich hier nicht kodieren</translation>
  </message>
  <message>
   <source>Choose a .webp file or a folder of PNG</source>
   <translation>Eine .webp-Datei oder einen Ordner mit PNG wählen</translation>
  </message>
  <message>
   <source>Adobe RGB (1998)</source>
   <translation>Adobe RGB (1998)</translation>
  </message>
  <message>
   <source>other primaries</source>
   <translation>andere Primärfarben</translation>
  </message>
  <message>
   <source>holds a radiance of %1, and what is computed here goes up to %2</source>
   <translation>enthält eine Strahldichte von %1; gerechnet wird hier bis %2</translation>
  </message>
  <message>
   <source>Scale it down, or correct the pixels that no lamp can have made</source>
   <translation>Herunterskalieren oder Pixel korrigieren, die keine Lampe erzeugt haben kann</translation>
  </message>
  <message>
   <source>is a Git LFS pointer, not the image itself</source>
   <translation>ist ein Git-LFS-Zeiger, nicht das Bild selbst</translation>
  </message>
  <message>
   <source>Run 'git lfs pull' where it lies</source>
   <translation>Dort, wo es liegt, 'git lfs pull' ausführen</translation>
  </message>
  <message>
   <source>is a PDF document</source>
   <translation>ist ein PDF-Dokument</translation>
  </message>
  <message>
   <source>Export its images as TIFF or PNG</source>
   <translation>Seine Bilder als TIFF oder PNG exportieren</translation>
  </message>
  <message>
   <source>is a GIF</source>
   <translation>ist ein GIF</translation>
  </message>
  <message>
   <source>Save it as PNG</source>
   <translation>Als PNG speichern</translation>
  </message>
  <message>
   <source>is a KTX texture</source>
   <translation>ist eine KTX-Textur</translation>
  </message>
  <message>
   <source>Convert it to PNG, with ktx extract for one</source>
   <translation>In PNG umwandeln, etwa mit ktx extract</translation>
  </message>
  <message>
   <source>is a DDS texture</source>
   <translation>ist eine DDS-Textur</translation>
  </message>
  <message>
   <source>Convert it to PNG</source>
   <translation>In PNG umwandeln</translation>
  </message>
  <message>
   <source>is a BMP image</source>
   <translation>ist ein BMP-Bild</translation>
  </message>
  <message>
   <source>is a zip archive</source>
   <translation>ist ein ZIP-Archiv</translation>
  </message>
  <message>
   <source>Unpack it first</source>
   <translation>Zuerst entpacken</translation>
  </message>
  <message>
   <source>is a text or web page</source>
   <translation>ist ein Text oder eine Webseite</translation>
  </message>
  <message>
   <source>Download the image itself</source>
   <translation>Das Bild selbst herunterladen</translation>
  </message>
  <message>
   <source>is a HEIF, AVIF or video file</source>
   <translation>ist eine HEIF-, AVIF- oder Videodatei</translation>
  </message>
  <message>
   <source>Save it as JPEG or TIFF</source>
   <translation>Als JPEG oder TIFF speichern</translation>
  </message>
  <message>
   <source>is not an image of a known kind</source>
   <translation>ist kein Bild bekannter Art</translation>
  </message>
  <message>
   <source>Give an image as %1 or camera RAW</source>
   <translation>Ein Bild als %1 oder Kamera-RAW angeben</translation>
  </message>
  <message>
   <source>samples are infinite</source>
   <translation>Abtastwerte sind unendlich</translation>
  </message>
  <message>
   <source>sample is infinite</source>
   <translation>Abtastwert ist unendlich</translation>
  </message>
  <message>
   <source>%1 %2 and taken as %3, the largest number of half floats</source>
   <translation>%1 %2 und gelten als %3, die größte Zahl halber Genauigkeit</translation>
  </message>
  <message>
   <source>has %1 pixels that are not finite; they are masked</source>
   <translation>hat %1 Pixel, die nicht endlich sind; sie werden maskiert</translation>
  </message>
  <message>
   <source>has no alpha channel that is read</source>
   <translation>hat keinen Alphakanal, der gelesen wird</translation>
  </message>
  <message>
   <source>Save it as a PNG</source>
   <translation>Als PNG speichern</translation>
  </message>
  <message>
   <source>has a colour profile that is not applied: it %1</source>
   <translation>hat ein Farbprofil, das nicht angewandt wird: es %1</translation>
  </message>
  <message>
   <source>has a colour profile that cannot be applied: it %1</source>
   <translation>hat ein Farbprofil, das sich nicht anwenden lässt: es %1</translation>
  </message>
  <message>
   <source>Save it with an RGB or grey profile or without one, or import it with --transfer srgb or linear, which takes its primaries as sRGB</source>
   <translation>Mit einem RGB- oder Graustufenprofil oder ohne Profil speichern, oder mit --transfer srgb oder linear importieren; dann gelten seine Primärfarben als sRGB</translation>
  </message>
  <message>
   <source>states that its colours are not sRGB, but not what they are: they are taken as sRGB</source>
   <translation>gibt an, dass seine Farben nicht sRGB sind, aber nicht, was sie sind: sie gelten als sRGB</translation>
  </message>
  <message>
   <source>has the colour profile %1, which is not applied to bands that are chosen</source>
   <translation>hat das Farbprofil %1, das auf gewählte Kanäle nicht angewandt wird</translation>
  </message>
  <message>
   <source>says that its samples are linear, but its colour profile %1 has another curve, which is used</source>
   <translation>nennt seine Abtastwerte linear, aber sein Farbprofil %1 hat eine andere Kurve; diese gilt</translation>
  </message>
  <message>
   <source>is not applied, because the transfer function is stated: its primaries are taken as sRGB</source>
   <translation>wird nicht angewandt, weil die Übertragungsfunktion angegeben ist: seine Primärfarben gelten als sRGB</translation>
  </message>
  <message>
   <source>has the colour profile %1 with a table, which %2</source>
   <translation>hat das Farbprofil %1 mit einer Tabelle, die %2</translation>
  </message>
  <message>
   <source>has the colour profile %1, of which the curve is not applied: the transfer function is stated</source>
   <translation>hat das Farbprofil %1, dessen Kurve nicht angewandt wird: die Übertragungsfunktion ist angegeben</translation>
  </message>
  <message>
   <source>%1 is for grey, and the image has colours</source>
   <translation>%1 ist für Graustufen, und das Bild hat Farben</translation>
  </message>
  <message>
   <source>, its last ones among them</source>
   <translation>, darunter die letzten</translation>
  </message>
  <message>
   <source>has %1 of %2 rows that are all zero%3: check that it is complete</source>
   <translation>hat %1 von %2 Zeilen, die ganz null sind%3: prüfen, ob es vollständig ist</translation>
  </message>
  <message>
   <source>Software</source>
   <translation>Software</translation>
  </message>
  <message>
   <source>Comment</source>
   <translation>Kommentar</translation>
  </message>
  <message>
   <source>Save it as an EXR image with channels R, G, B</source>
   <translation>Als EXR-Bild mit den Kanälen R, G, B speichern</translation>
  </message>
  <message>
   <source>has no channels R, G, B; its layer %1 is used</source>
   <translation>hat keine Kanäle R, G, B; seine Ebene %1 wird verwendet</translation>
  </message>
  <message>
   <source>has integer colour channels</source>
   <translation>hat ganzzahlige Farbkanäle</translation>
  </message>
  <message>
   <source>has an alpha channel, which is ignored</source>
   <translation>hat einen Alphakanal, der nicht beachtet wird</translation>
  </message>
  <message>
   <source>has channels X, Y, Z, which are taken as CIE tristimulus values</source>
   <translation>hat Kanäle X, Y, Z, die als CIE-Normfarbwerte gelten</translation>
  </message>
  <message>
   <source>states %1</source>
   <translation>gibt an: %1</translation>
  </message>
  <message>
   <source>has no alpha channel</source>
   <translation>hat keinen Alphakanal</translation>
  </message>
  <message>
   <source>Save it with its fourth channel</source>
   <translation>Mit seinem vierten Kanal speichern</translation>
  </message>
  <message>
   <source>has channels of different resolution</source>
   <translation>hat Kanäle verschiedener Auflösung</translation>
  </message>
  <message>
   <source>the first</source>
   <translation>der erste</translation>
  </message>
  <message>
   <source>part %1, the first with channels R, G, B,</source>
   <translation>Teil %1, der erste mit Kanälen R, G, B,</translation>
  </message>
  <message>
   <source>has %1 parts, of which %2 is used</source>
   <translation>hat %1 Teile, von denen %2 verwendet wird</translation>
  </message>
  <message>
   <source>stores a part of the area that it displays; the rest is black</source>
   <translation>speichert einen Teil der Fläche, die es anzeigt; der Rest ist schwarz</translation>
  </message>
  <message>
   <source>stores another area than it displays; all that is stored is used</source>
   <translation>speichert eine andere Fläche, als es anzeigt; alles Gespeicherte wird verwendet</translation>
  </message>
  <message>
   <source>is a deep EXR image</source>
   <translation>ist ein tiefes EXR-Bild</translation>
  </message>
  <message>
   <source>is an EXR image without channels</source>
   <translation>ist ein EXR-Bild ohne Kanäle</translation>
  </message>
  <message>
   <source>is an incomplete EXR image: its table of chunks is empty</source>
   <translation>ist ein unvollständiges EXR-Bild: die Tabelle seiner Blöcke ist leer</translation>
  </message>
  <message>
   <source>is an incomplete EXR image: some of its chunks are missing</source>
   <translation>ist ein unvollständiges EXR-Bild: einige seiner Blöcke fehlen</translation>
  </message>
  <message>
   <source>is a damaged EXR image: its chunks are not those of the size it states</source>
   <translation>ist ein beschädigtes EXR-Bild: seine Blöcke passen nicht zur angegebenen Größe</translation>
  </message>
  <message>
   <source>stores luminance and chroma (Y, RY, BY)</source>
   <translation>speichert Leuchtdichte und Farbe (Y, RY, BY)</translation>
  </message>
  <message>
   <source>has no channels R, G, B but %1</source>
   <translation>hat keine Kanäle R, G, B, sondern %1</translation>
  </message>
  <message>
   <source>is a damaged Radiance image (its size is missing)</source>
   <translation>ist ein beschädigtes Radiance-Bild (seine Größe fehlt)</translation>
  </message>
  <message>
   <source>states a gamma of %1, which is not applied</source>
   <translation>gibt ein Gamma von %1 an, das nicht angewandt wird</translation>
  </message>
  <message>
   <source>states primaries that are not eight numbers</source>
   <translation>gibt Primärfarben an, die nicht acht Zahlen sind</translation>
  </message>
  <message>
   <source>is an incomplete Radiance image: it ends before its image does</source>
   <translation>ist ein unvollständiges Radiance-Bild: es endet vor seinem Bild</translation>
  </message>
  <message>
   <source>is a damaged Radiance image: its runs repeat nothing, or far too much</source>
   <translation>ist ein beschädigtes Radiance-Bild: seine Läufe wiederholen nichts oder viel zu viel</translation>
  </message>
  <message>
   <source>is an incomplete Radiance image: its runs do not end where its image does</source>
   <translation>ist ein unvollständiges Radiance-Bild: seine Läufe enden nicht mit dem Bild</translation>
  </message>
  <message>
   <source>says that its exposure is not a factor above 0</source>
   <translation>gibt eine Belichtung an, die kein Faktor über 0 ist</translation>
  </message>
  <message>
   <source>Correct the EXPOSURE and COLORCORR lines of its header</source>
   <translation>Die Zeilen EXPOSURE und COLORCORR seines Kopfs korrigieren</translation>
  </message>
  <message>
   <source>CIE L*a*b*</source>
   <translation>CIE L*a*b*</translation>
  </message>
  <message>
   <source>CIE XYZ</source>
   <translation>CIE XYZ</translation>
  </message>
  <message>
   <source>has more than %1 MiB</source>
   <translation>hat mehr als %1 MiB</translation>
  </message>
  <message>
   <source>is not an ICC profile</source>
   <translation>ist kein ICC-Profil</translation>
  </message>
  <message>
   <source>is truncated: %1 of %2 bytes are there</source>
   <translation>ist abgeschnitten: %1 von %2 Bytes sind vorhanden</translation>
  </message>
  <message>
   <source>%1 is for %2</source>
   <translation>%1 gilt für %2</translation>
  </message>
  <message>
   <source>%1 does not describe the colours of a device</source>
   <translation>%1 beschreibt nicht die Farben eines Geräts</translation>
  </message>
  <message>
   <source>%1 states grey as lightness</source>
   <translation>%1 gibt Grau als Helligkeit an</translation>
  </message>
  <message>
   <source>Linear Rec. 709</source>
   <translation>Lineares Rec. 709</translation>
  </message>
  <message>
   <source>sRGB IEC61966-2.1</source>
   <translation>sRGB IEC61966-2.1</translation>
  </message>
  <message>
   <source>No rights reserved</source>
   <translation>Keine Rechte vorbehalten</translation>
  </message>
  <message>
   <source>is damaged: its list of tags does not fit into it</source>
   <translation>ist beschädigt: seine Liste der Tags passt nicht hinein</translation>
  </message>
  <message>
   <source>is damaged: a tag lies outside it</source>
   <translation>ist beschädigt: ein Tag liegt außerhalb</translation>
  </message>
  <message>
   <source>without a name</source>
   <translation>ohne Namen</translation>
  </message>
  <message>
   <source>is damaged: it has no %1</source>
   <translation>ist beschädigt: es hat kein %1</translation>
  </message>
  <message>
   <source>has a curve that no samples have</source>
   <translation>hat eine Kurve, die keine Abtastwerte haben</translation>
  </message>
  <message>
   <source>has a curve that does not rise</source>
   <translation>hat eine Kurve, die nicht steigt</translation>
  </message>
  <message>
   <source>has a curve that does not lead from black to white</source>
   <translation>hat eine Kurve, die nicht von Schwarz zu Weiß führt</translation>
  </message>
  <message>
   <source>has primaries that do not add up to white</source>
   <translation>hat Primärfarben, die zusammen nicht Weiß ergeben</translation>
  </message>
  <message>
   <source>has primaries that do not add up to its white</source>
   <translation>hat Primärfarben, die zusammen nicht sein Weiß ergeben</translation>
  </message>
  <message>
   <source>%1 has a table that cannot be read</source>
   <translation>%1 hat eine Tabelle, die sich nicht lesen lässt</translation>
  </message>
  <message>
   <source>%1 has a table in which greys do not rise</source>
   <translation>%1 hat eine Tabelle, in der Grauwerte nicht steigen</translation>
  </message>
  <message>
   <source>%1 has a table that does not lead from black to white</source>
   <translation>%1 hat eine Tabelle, die nicht von Schwarz zu Weiß führt</translation>
  </message>
  <message>
   <source>of %1 components</source>
   <translation>mit %1 Komponenten</translation>
  </message>
  <message>
   <source>is a JPEG %1</source>
   <translation>ist ein JPEG %1</translation>
  </message>
  <message>
   <source>is a %1 JPEG</source>
   <translation>ist ein %1-JPEG</translation>
  </message>
  <message>
   <source>is a damaged JPEG (%1)</source>
   <translation>ist ein beschädigtes JPEG (%1)</translation>
  </message>
  <message>
   <source>it cannot be decoded</source>
   <translation>es lässt sich nicht dekodieren</translation>
  </message>
  <message>
   <source>is a JPEG without an image</source>
   <translation>ist ein JPEG ohne Bild</translation>
  </message>
  <message>
   <source>is a damaged JPEG (no marker at byte %1)</source>
   <translation>ist ein beschädigtes JPEG (keine Marke bei Byte %1)</translation>
  </message>
  <message>
   <source>is an incomplete JPEG: it ends before its image does</source>
   <translation>ist ein unvollständiges JPEG: es endet vor seinem Bild</translation>
  </message>
  <message>
   <source>is a damaged PFM image (its header is not one)</source>
   <translation>ist ein beschädigtes PFM-Bild (ungültiger Kopf)</translation>
  </message>
  <message>
   <source>is a PFM image that states no order of its bytes</source>
   <translation>ist ein PFM-Bild ohne Angabe der Bytereihenfolge</translation>
  </message>
  <message>
   <source>is an incomplete PFM image: it ends before its image does</source>
   <translation>ist ein unvollständiges PFM-Bild: es endet vor seinem Bild</translation>
  </message>
  <message>
   <source>states a scale of %1, which is not applied</source>
   <translation>gibt einen Maßstab von %1 an, der nicht angewandt wird</translation>
  </message>
  <message>
   <source>is a damaged PNG (its header is wrong)</source>
   <translation>ist ein beschädigtes PNG (falscher Kopf)</translation>
  </message>
  <message>
   <source>is a damaged PNG (%1)</source>
   <translation>ist ein beschädigtes PNG (%1)</translation>
  </message>
  <message>
   <source>is an incomplete PNG: it ends before its image does</source>
   <translation>ist ein unvollständiges PNG: es endet vor seinem Bild</translation>
  </message>
  <message>
   <source>is a damaged PNG (wrong checksum at byte %1)</source>
   <translation>ist ein beschädigtes PNG (falsche Prüfsumme bei Byte %1)</translation>
  </message>
  <message>
   <source>states a gamma that no image has</source>
   <translation>gibt ein Gamma an, das kein Bild hat</translation>
  </message>
  <message>
   <source>states primaries that no colours have</source>
   <translation>gibt Primärfarben an, die keine Farben haben</translation>
  </message>
  <message>
   <source>gAMA and cHRM of the file</source>
   <translation>gAMA und cHRM der Datei</translation>
  </message>
  <message>
   <source>has the coding (cICP) %1, which is not for photographs</source>
   <translation>hat die Kodierung (cICP) %1, die nicht für Fotos ist</translation>
  </message>
  <message>
   <source>cICP %1-%2</source>
   <translation>cICP %1-%2</translation>
  </message>
  <message>
   <source>Save it with its fourth channel, as a PNG</source>
   <translation>Mit seinem vierten Kanal als PNG speichern</translation>
  </message>
  <message>
   <source>is a damaged PNG (it cannot be decoded)</source>
   <translation>ist ein beschädigtes PNG (es lässt sich nicht dekodieren)</translation>
  </message>
  <message>
   <source>Save it as an RGB or grey image with 8 or 16 bits, or as EXR</source>
   <translation>Als RGB- oder Graustufenbild mit 8 oder 16 Bit oder als EXR speichern</translation>
  </message>
  <message>
   <source>holds %1 band%2, and no band %3</source>
   <translation>enthält %1 Kanäle, aber keinen Kanal %3</translation>
  </message>
  <message>
   <source>Choose one or three of the bands 1 to %1</source>
   <translation>Einen oder drei der Kanäle 1 bis %1 wählen</translation>
  </message>
  <message>
   <source>has an alpha or extra channel, which is ignored</source>
   <translation>hat einen Alpha- oder Zusatzkanal, der nicht beachtet wird</translation>
  </message>
  <message>
   <source>has %1 bands, of which the first %2 used</source>
   <translation>hat %1 Kanäle, von denen nur die ersten verwendet werden</translation>
  </message>
  <message>
   <source>%1 are</source>
   <translation>%1 sind</translation>
  </message>
  <message>
   <source>says it has %1 × %2 pixels</source>
   <translation>hat angeblich %1 × %2 Pixel</translation>
  </message>
  <message>
   <source>Export it again</source>
   <translation>Neu exportieren</translation>
  </message>
  <message>
   <source>says it has %1 × %2 pixels, more than the limit of %3 megapixels</source>
   <translation>gibt %1 × %2 Pixel an, mehr als die Grenze von %3 Megapixeln</translation>
  </message>
  <message>
   <source>Scale it down, or export it again if it is smaller than that</source>
   <translation>Herunterskalieren oder, wenn es kleiner ist, neu exportieren</translation>
  </message>
  <message>
   <source>needs %1 decoded, more than the limit of 4 GiB</source>
   <translation>braucht dekodiert %1, mehr als die Grenze von 4 GiB</translation>
  </message>
  <message>
   <source>Scale it down</source>
   <translation>Herunterskalieren</translation>
  </message>
  <message>
   <source>says it has %1 × %2 pixels, which %3 bytes cannot hold</source>
   <translation>gibt %1 × %2 Pixel an, die %3 Bytes nicht enthalten können</translation>
  </message>
  <message>
   <source>is a damaged Targa image: it holds more rows than it states</source>
   <translation>ist ein beschädigtes Targa-Bild: es enthält mehr Zeilen als angegeben</translation>
  </message>
  <message>
   <source>is a damaged or incomplete Targa image</source>
   <translation>ist ein beschädigtes oder unvollständiges Targa-Bild</translation>
  </message>
  <message>
   <source>is a Targa image of black and white alone</source>
   <translation>ist ein Targa-Bild nur in Schwarz und Weiß</translation>
  </message>
  <message>
   <source>Save it as an RGB or grey image</source>
   <translation>Als RGB- oder Graubild speichern</translation>
  </message>
  <message>
   <source>has five bits for each channel, too few to measure light</source>
   <translation>hat fünf Bit je Kanal, zu wenig, um Licht zu messen</translation>
  </message>
  <message>
   <source>a mask</source>
   <translation>eine Maske</translation>
  </message>
  <message>
   <source>ICC L*a*b*</source>
   <translation>ICC L*a*b*</translation>
  </message>
  <message>
   <source>ITU L*a*b*</source>
   <translation>ITU L*a*b*</translation>
  </message>
  <message>
   <source>has %1 pages, of which the first is used</source>
   <translation>hat %1 Seiten, von denen die erste verwendet wird</translation>
  </message>
  <message>
   <source>has an extra channel, which is ignored</source>
   <translation>hat einen Zusatzkanal, der nicht beachtet wird</translation>
  </message>
  <message>
   <source>has colours that were multiplied by its alpha channel, which was undone</source>
   <translation>hat Farben, die mit seinem Alphakanal multipliziert waren, was rückgängig gemacht wurde</translation>
  </message>
  <message>
   <source>is a TIFF volume of %1 slices</source>
   <translation>ist ein TIFF-Volumen mit %1 Schichten</translation>
  </message>
  <message>
   <source>is a TIFF in %1</source>
   <translation>ist ein TIFF in %1</translation>
  </message>
  <message>
   <source>signed integers</source>
   <translation>ganze Zahlen mit Vorzeichen</translation>
  </message>
  <message>
   <source>sample format %1</source>
   <translation>Abtastformat %1</translation>
  </message>
  <message>
   <source>is a TIFF of %1</source>
   <translation>ist ein TIFF aus %1</translation>
  </message>
  <message>
   <source>is a TIFF of %1 samples per pixel</source>
   <translation>ist ein TIFF mit %1 Werten je Pixel</translation>
  </message>
  <message>
   <source>is an incomplete TIFF: the value of its tag %1 is missing</source>
   <translation>ist ein unvollständiges TIFF: der Wert seiner Angabe %1 fehlt</translation>
  </message>
  <message>
   <source>is a damaged TIFF (its size needs %1 strips or tiles, %2 are listed)</source>
   <translation>ist ein beschädigtes TIFF (seine Größe braucht %1 Streifen oder Kacheln, %2 sind verzeichnet)</translation>
  </message>
  <message>
   <source>is an incomplete TIFF: it ends before its image does</source>
   <translation>ist ein unvollständiges TIFF: es endet vor seinem Bild</translation>
  </message>
  <message>
   <source>is a damaged TIFF (its strips or tiles overlap)</source>
   <translation>ist ein beschädigtes TIFF (seine Streifen oder Kacheln überlappen)</translation>
  </message>
  <message>
   <source>is a damaged TIFF (its strips or tiles do not fit its size)</source>
   <translation>ist ein beschädigtes TIFF (seine Streifen oder Kacheln passen nicht zur Größe)</translation>
  </message>
  <message>
   <source>is a damaged TIFF (its palette is too short)</source>
   <translation>ist ein beschädigtes TIFF (seine Palette ist zu kurz)</translation>
  </message>
  <message>
   <source>has 1 bit per pixel: black and white only</source>
   <translation>hat 1 Bit je Pixel: nur Schwarz und Weiß</translation>
  </message>
  <message>
   <source>the colour tags of the TIFF</source>
   <translation>die Farb-Tags des TIFF</translation>
  </message>
  <message>
   <source>has a transfer function (TIFF tag 301) of another length than its samples need</source>
   <translation>hat eine Übertragungsfunktion (TIFF-Tag 301) von anderer Länge, als seine Abtastwerte brauchen</translation>
  </message>
  <message>
   <source>is a damaged LogLuv TIFF (%1)</source>
   <translation>ist ein beschädigtes LogLuv-TIFF (%1)</translation>
  </message>
  <message>
   <source>meet again</source>
   <translation>treffen sich wieder</translation>
  </message>
  <message>
   <source>or their tags are too many</source>
   <translation>oder ihre Tags sind zu viele</translation>
  </message>
  <message>
   <source>is a damaged TIFF (its directories %1)</source>
   <translation>ist ein beschädigtes TIFF (seine Verzeichnisse %1)</translation>
  </message>
  <message>
   <source>is a damaged TIFF (a directory has %1 below it)</source>
   <translation>ist ein beschädigtes TIFF (ein Verzeichnis hat %1 unter sich)</translation>
  </message>
  <message>
   <source>is a damaged TIFF (its tags hold more than the file)</source>
   <translation>ist ein beschädigtes TIFF (seine Angaben enthalten mehr als die Datei)</translation>
  </message>
 </context>
 <context>
  <name>engine/geometry</name>
  <message>
   <source>Angle of the brushing.</source>
   <translation>Winkel der Bürstung.</translation>
  </message>
  <message>
   <source>a brushing direction %1 is not a vector of a length; give x, y, z or 1,0,0</source>
   <translation>eine Bürstrichtung %1 ist kein Vektor mit Länge; x, y, z oder 1,0,0 angeben</translation>
  </message>
  <message>
   <source>%1 is not a brushing direction; give u for the texture's, x, y, z or a vector as 1,0,0, and an angle behind a colon: y:30</source>
   <translation>%1 ist keine Bürstrichtung; u für die der Textur, x, y, z oder einen Vektor wie 1,0,0 angeben, und einen Winkel hinter einem Doppelpunkt: y:30</translation>
  </message>
  <message>
   <source>%1 needs three finite numbers, got %2</source>
   <translation>%1 braucht drei endliche Zahlen, nicht %2</translation>
  </message>
  <message>
   <source>%1 has coordinates beyond ±%2, got %3</source>
   <translation>%1 hat Koordinaten jenseits von ±%2: %3</translation>
  </message>
  <message>
   <source>fov_deg = %1 is outside [0.01, 179] °</source>
   <translation>fov_deg = %1 liegt außerhalb von [0,01, 179] °</translation>
  </message>
  <message>
   <source>eye and target are the same point</source>
   <translation>Auge und Ziel sind derselbe Punkt</translation>
  </message>
  <message>
   <source>up is parallel to the direction of view</source>
   <translation>die Senkrechte ist parallel zur Blickrichtung</translation>
  </message>
  <message>
   <source>unknown camera setting %1%2; choose from %3</source>
   <translation>unbekannte Kameraeinstellung %1%2; möglich: %3</translation>
  </message>
  <message>
   <source>%1 is not made of numbers</source>
   <translation>%1 besteht nicht aus Zahlen</translation>
  </message>
  <message>
   <source>%1 needs %2</source>
   <translation>%1 braucht %2</translation>
  </message>
  <message>
   <source>three numbers</source>
   <translation>drei Zahlen</translation>
  </message>
  <message>
   <source>%1 fov_deg=%2</source>
   <translation>%1 fov_deg=%2</translation>
  </message>
  <message>
   <source>embree could not make a scene</source>
   <translation>Embree konnte keine Szene anlegen</translation>
  </message>
  <message>
   <source>embree could not build its tree over %1 faces</source>
   <translation>Embree konnte seinen Baum über %1 Flächen nicht aufbauen</translation>
  </message>
  <message>
   <source>embree has no room for %1 rows of a mesh</source>
   <translation>Embree hat keinen Platz für %1 Zeilen eines Netzes</translation>
  </message>
  <message>
   <source>embree could not be started</source>
   <translation>Embree ließ sich nicht starten</translation>
  </message>
  <message>
   <source>no material</source>
   <translation>kein Material</translation>
  </message>
  <message>
   <source>material %1</source>
   <translation>Material %1</translation>
  </message>
  <message>
   <source>Export it without that: gltfpack without -c, or gltf-transform copy</source>
   <translation>Ohne das exportieren: gltfpack ohne -c oder gltf-transform copy</translation>
  </message>
  <message>
   <source>uses meshopt compression, which is not read</source>
   <translation>verwendet meshopt-Kompression, die nicht gelesen wird</translation>
  </message>
  <message>
   <source>Install the extra draco: pip install 'lightarc[draco]', or export it without that</source>
   <translation>Das Zusatzpaket draco installieren: pip install 'lightarc[draco]', oder ohne das exportieren</translation>
  </message>
  <message>
   <source>uses Draco compression, for which the library DracoPy is not installed</source>
   <translation>verwendet Draco-Kompression, für die die Bibliothek DracoPy nicht installiert ist</translation>
  </message>
  <message>
   <source>is glTF %1; only GLTF 2 is read</source>
   <translation>ist glTF %1; nur glTF 2 wird gelesen</translation>
  </message>
  <message>
   <source>Export it as glTF 2.0</source>
   <translation>Als glTF 2.0 exportieren</translation>
  </message>
  <message>
   <source>has %1 nodes, more than %2</source>
   <translation>hat %1 Knoten, mehr als %2</translation>
  </message>
  <message>
   <source>Join its parts and export it again</source>
   <translation>Seine Teile verbinden und neu exportieren</translation>
  </message>
  <message>
   <source>is damaged: a node names node %1, which is not there</source>
   <translation>ist beschädigt: ein Knoten nennt den fehlenden Knoten %1</translation>
  </message>
  <message>
   <source>has nodes within nodes over more than %1 levels</source>
   <translation>hat Knoten in Knoten über mehr als %1 Stufen</translation>
  </message>
  <message>
   <source>Apply the transforms of its groups and export it again</source>
   <translation>Die Transformationen seiner Gruppen anwenden und neu exportieren</translation>
  </message>
  <message>
   <source>is damaged: its nodes lie within each other in a circle</source>
   <translation>ist beschädigt: seine Knoten enthalten sich im Kreis</translation>
  </message>
  <message>
   <source>is damaged: its compressed numbers are not as many as it says</source>
   <translation>ist beschädigt: es sind nicht so viele komprimierte Zahlen, wie angegeben</translation>
  </message>
  <message>
   <source>is damaged: an accessor has no data</source>
   <translation>ist beschädigt: ein Accessor hat keine Daten</translation>
  </message>
  <message>
   <source>keeps its data elsewhere (%1)</source>
   <translation>hat seine Daten an einem anderen Ort (%1)</translation>
  </message>
  <message>
   <source>Export it as .glb</source>
   <translation>Als .glb exportieren</translation>
  </message>
  <message>
   <source>is damaged: an accessor names bytes that are not there</source>
   <translation>ist beschädigt: ein Accessor nennt fehlende Bytes</translation>
  </message>
  <message>
   <source>a ground at the height %1 is not possible</source>
   <translation>ein Boden in der Höhe %1 ist nicht möglich</translation>
  </message>
  <message>
   <source>a ground of albedo %1 (0 … 1), extent %2 (above 0) and %3 cells (1 … %4) is not possible</source>
   <translation>ein Boden mit Albedo %1 (0 … 1), Ausdehnung %2 (über 0) und %3 Zellen (1 … %4) ist nicht möglich</translation>
  </message>
  <message>
   <source>It holds points or curves; give a mesh with faces, as .ply or .obj</source>
   <translation>Es enthält Punkte oder Kurven; ein Netz mit Flächen angeben, als .ply oder .obj</translation>
  </message>
  <message>
   <source>Unpack it and give the mesh that is in it</source>
   <translation>Entpacken und das Netz darin angeben</translation>
  </message>
  <message>
   <source>Export it as .stl, .obj or .glb</source>
   <translation>Als .stl, .obj oder .glb exportieren</translation>
  </message>
  <message>
   <source>Convert it to .ply</source>
   <translation>In .ply umwandeln</translation>
  </message>
  <message>
   <source>Export the tessellated shape as .stl or .obj</source>
   <translation>Die tessellierte Form als .stl oder .obj exportieren</translation>
  </message>
  <message>
   <source>no ending</source>
   <translation>keine Endung</translation>
  </message>
  <message>
   <source>is not a mesh that can be read (%1)</source>
   <translation>ist kein lesbares Netz (%1)</translation>
  </message>
  <message>
   <source>vertices must be an array V × 3 of numbers, not %1 %2</source>
   <translation>Eckpunkte müssen ein Feld V × 3 von Zahlen sein, nicht %1 %2</translation>
  </message>
  <message>
   <source>faces must be an array F × 3 of vertex indices, not %1 %2</source>
   <translation>Flächen müssen ein Feld F × 3 von Eckpunktnummern sein, nicht %1 %2</translation>
  </message>
  <message>
   <source>faces name vertices %1 to %2, and there are %3 from 0</source>
   <translation>Flächen nennen Eckpunkte %1 bis %2, und es gibt %3 ab 0</translation>
  </message>
  <message>
   <source>uv must be an array %1 × 2, one row a vertex, not %2</source>
   <translation>uv muss ein Feld %1 × 2 sein, eine Zeile je Eckpunkt, nicht %2</translation>
  </message>
  <message>
   <source>holds no triangles</source>
   <translation>enthält keine Dreiecke</translation>
  </message>
  <message>
   <source>Give a mesh with faces, not points or curves alone</source>
   <translation>Ein Netz mit Flächen angeben, nicht nur Punkte oder Kurven</translation>
  </message>
  <message>
   <source>holds no usable triangle (%1)</source>
   <translation>enthält kein brauchbares Dreieck (%1)</translation>
  </message>
  <message>
   <source>is %1 across, too small to be drawn</source>
   <translation>misst %1, zu klein zum Zeichnen</translation>
  </message>
  <message>
   <source>Scale it to more than %1</source>
   <translation>Auf mehr als %1 vergrößern</translation>
  </message>
  <message>
   <source>%1 excluded</source>
   <translation>%1 ausgeschlossen</translation>
  </message>
  <message>
   <source>points were moved by less than %1 of the size, to close gaps that rounding had left</source>
   <translation>Punkte wurden um weniger als %1 der Größe verschoben, um Rundungslücken zu schließen</translation>
  </message>
  <message>
   <source>subdivision surfaces are drawn as their control meshes</source>
   <translation>Unterteilungsflächen werden als ihre Kontrollnetze gezeichnet</translation>
  </message>
  <message>
   <source>faces were turned, so that neighbours are alike and closed parts face outwards</source>
   <translation>Flächen wurden gewendet, sodass Nachbarn gleich liegen und geschlossene Teile nach außen zeigen</translation>
  </message>
  <message>
   <source>normals were none and taken from the faces</source>
   <translation>Normalen fehlten und wurden aus den Flächen berechnet</translation>
  </message>
  <message>
   <source>faces without texture coordinates got those of a box</source>
   <translation>Flächen ohne Texturkoordinaten bekamen die eines Quaders</translation>
  </message>
  <message>
   <source>the surface is inside out; it can be flipped</source>
   <translation>die Oberfläche ist umgestülpt; sie lässt sich wenden</translation>
  </message>
  <message>
   <source>edges are open: the surface has borders or holes</source>
   <translation>Kanten sind offen: die Oberfläche hat Ränder oder Löcher</translation>
  </message>
  <message>
   <source>edges have more than two faces</source>
   <translation>Kanten haben mehr als zwei Flächen</translation>
  </message>
  <message>
   <source>edges have faces that are turned against each other</source>
   <translation>Kanten haben Flächen, die gegeneinander gedreht sind</translation>
  </message>
  <message>
   <source>points lie within edges of other faces (T-junctions), where light may pass through</source>
   <translation>Punkte liegen in Kanten anderer Flächen (T-Stöße), wo Licht durchdringen kann</translation>
  </message>
  <message>
   <source>is damaged: of %1 lines that it announces, %2 follow</source>
   <translation>ist beschädigt: von %1 angekündigten Zeilen folgen %2</translation>
  </message>
  <message>
   <source>is damaged: line %1 gives a corner with too many parts</source>
   <translation>ist beschädigt: Zeile %1 enthält eine Ecke mit zu vielen Teilen</translation>
  </message>
  <message>
   <source>is damaged: line %1 gives a corner without a point</source>
   <translation>ist beschädigt: Zeile %1 enthält eine Ecke ohne Punkt</translation>
  </message>
  <message>
   <source>is damaged: an index in line %1 is not a whole number</source>
   <translation>ist beschädigt: ein Index in Zeile %1 ist keine ganze Zahl</translation>
  </message>
  <message>
   <source>is damaged: %1 numbers are missing in line %2</source>
   <translation>ist beschädigt: %1 Zahlen fehlen in Zeile %2</translation>
  </message>
  <message>
   <source>is damaged: %1 in line %2 is not a number</source>
   <translation>ist beschädigt: %1 in Zeile %2 ist keine Zahl</translation>
  </message>
  <message>
   <source>is damaged or of an unknown kind: it does not begin with OFF</source>
   <translation>ist beschädigt oder von unbekannter Art: es beginnt nicht mit OFF</translation>
  </message>
  <message>
   <source>is OFF of a kind that is not read (binary, or of four dimensions)</source>
   <translation>ist OFF einer Art, die nicht gelesen wird (binär oder vierdimensional)</translation>
  </message>
  <message>
   <source>Export it as PLY</source>
   <translation>Als PLY exportieren</translation>
  </message>
  <message>
   <source>is damaged: it announces %1 vertices and faces, which do not follow</source>
   <translation>ist beschädigt: angekündigt sind %1 Eckpunkte und Flächen, die nicht folgen</translation>
  </message>
  <message>
   <source>is damaged: line %1 names %2 corners and gives fewer</source>
   <translation>ist beschädigt: Zeile %1 nennt %2 Ecken und gibt weniger an</translation>
  </message>
  <message>
   <source>is damaged: line %1 does not begin with counts</source>
   <translation>ist beschädigt: Zeile %1 beginnt nicht mit Anzahlen</translation>
  </message>
  <message>
   <source>is damaged or of an unknown kind (%1)</source>
   <translation>ist beschädigt oder von unbekannter Art (%1)</translation>
  </message>
  <message>
   <source>keeps its data in %1 files</source>
   <translation>hat seine Daten in %1 Dateien</translation>
  </message>
  <message>
   <source>Copy that as well, or export it as .glb</source>
   <translation>Diese mitkopieren oder als .glb exportieren</translation>
  </message>
  <message>
   <source>has about %1 million triangles and needs about %2 GiB of memory, of which %3 GiB are free</source>
   <translation>hat etwa %1 Millionen Dreiecke und braucht etwa %2 GiB Speicher, von denen %3 GiB frei sind</translation>
  </message>
  <message>
   <source>Reduce it in a modelling program, or close other programs</source>
   <translation>In einem Modellierprogramm verkleinern oder andere Programme schließen</translation>
  </message>
  <message>
   <source>flat image</source>
   <translation>flaches Bild</translation>
  </message>
  <message>
   <source>is neither a built-in model nor a file%1</source>
   <translation>ist weder ein eingebautes Modell noch eine Datei%1</translation>
  </message>
  <message>
   <source>Give a file or %1</source>
   <translation>Eine Datei angeben oder %1</translation>
  </message>
  <message>
   <source>the mesh has %1 faces, and charts are cut for at most %2</source>
   <translation>das Netz hat %1 Flächen, und UV-Inseln werden für höchstens %2 geschnitten</translation>
  </message>
  <message>
   <source>the mesh has %1 parts, and charts are cut for at most %2</source>
   <translation>das Netz hat %1 Teile, und UV-Inseln werden für höchstens %2 geschnitten</translation>
  </message>
  <message>
   <source>texture coordinates were made, in charts that do not overlap</source>
   <translation>Texturkoordinaten entstanden, in Karten ohne Überlappung</translation>
  </message>
  <message>
   <source>charts could not be cut (%1)</source>
   <translation>UV-Inseln ließen sich nicht schneiden (%1)</translation>
  </message>
  <message>
   <source>texture coordinates were made by a box projection: %1</source>
   <translation>Texturkoordinaten entstanden durch eine Quaderprojektion: %1</translation>
  </message>
  <message>
   <source>they have no size in 32 bits where a mesh is much longer than wide</source>
   <translation>sie haben in 32 Bit keine Größe, wo ein Netz viel länger als breit ist</translation>
  </message>
  <message>
   <source>Cut them elsewhere</source>
   <translation>An anderer Stelle schneiden</translation>
  </message>
  <message>
   <source>Install the extra usd: pip install 'lightarc[usd]', or export it as .glb</source>
   <translation>Das Zusatzpaket usd installieren: pip install 'lightarc[usd]', oder als .glb exportieren</translation>
  </message>
  <message>
   <source>is USD, which is read by the library usd-core, and that is not installed</source>
   <translation>ist USD, das die Bibliothek usd-core liest, und die ist nicht installiert</translation>
  </message>
  <message>
   <source>Copy that as well, or export it as .usdz</source>
   <translation>Diese mitkopieren oder als .usdz exportieren</translation>
  </message>
  <message>
   <source>names more than %1 layers, or layers in a circle</source>
   <translation>nennt mehr als %1 Ebenen oder Ebenen im Kreis</translation>
  </message>
  <message>
   <source>Export it as .usdz</source>
   <translation>Als .usdz exportieren</translation>
  </message>
  <message>
   <source>names a layer outside its folder (%1)</source>
   <translation>nennt eine Ebene außerhalb seines Ordners (%1)</translation>
  </message>
  <message>
   <source>is damaged: a value in it is of another type or length</source>
   <translation>ist beschädigt: ein Wert darin hat einen anderen Typ oder eine andere Länge</translation>
  </message>
  <message>
   <source>its text is not UTF-8</source>
   <translation>sein Text ist nicht UTF-8</translation>
  </message>
  <message>
   <source>is damaged: the library of USD does not read it (%1)</source>
   <translation>ist beschädigt: die Bibliothek von USD liest es nicht (%1)</translation>
  </message>
  <message>
   <source>is damaged: the library of USD does not read it</source>
   <translation>ist beschädigt: die Bibliothek von USD liest es nicht</translation>
  </message>
  <message>
   <source>has more than %1 prims</source>
   <translation>hat mehr als %1 Prims</translation>
  </message>
  <message>
   <source>is damaged: an instance has a prototype that is not there</source>
   <translation>ist beschädigt: eine Instanz hat einen Prototyp, den es nicht gibt</translation>
  </message>
  <message>
   <source>has faces of more than %1 corners</source>
   <translation>hat Flächen mit mehr als %1 Ecken</translation>
  </message>
  <message>
   <source>Reduce it</source>
   <translation>Es verkleinern</translation>
  </message>
  <message>
   <source>is damaged: %1 has other corners than its faces count</source>
   <translation>ist beschädigt: %1 hat andere Ecken, als seine Flächen zählen</translation>
  </message>
  <message>
   <source>UVMap</source>
   <translation>UVMap</translation>
  </message>
 </context>
 <context>
  <name>engine/light</name>
  <message>
   <source>%1 × %2 texels</source>
   <translation>%1 × %2 Texel</translation>
  </message>
  <message>
   <source>is a cube map of OpenEXR; it was converted to latitude and longitude</source>
   <translation>ist eine Würfelkarte von OpenEXR; sie wurde in Länge und Breite umgewandelt</translation>
  </message>
  <message>
   <source>a strip of six faces</source>
   <translation>ein Streifen aus sechs Flächen</translation>
  </message>
  <message>
   <source>a cross</source>
   <translation>ein Kreuz</translation>
  </message>
  <message>
   <source>is a cube map laid out as %1; it was converted to latitude and longitude</source>
   <translation>ist eine Würfelkarte, angeordnet als %1; sie wurde in Länge und Breite umgewandelt</translation>
  </message>
  <message>
   <source>its faces were mirrored, because only then they fit together</source>
   <translation>ihre Flächen wurden gespiegelt, weil sie nur so zusammenpassen</translation>
  </message>
  <message>
   <source>its faces do not fit together at their edges: their order or orientation may be another</source>
   <translation>ihre Flächen passen an den Kanten nicht zusammen: Reihenfolge oder Lage sind vielleicht anders</translation>
  </message>
  <message>
   <source>Give the equirectangular (latitude-longitude) form, twice as wide as high, or a cube map as a strip or a cross</source>
   <translation>Die äquirektangulare Form (Länge und Breite), doppelt so breit wie hoch, angeben, oder eine Würfelkarte als Streifen oder Kreuz</translation>
  </message>
  <message>
   <source>is neither a file nor a built-in environment%1</source>
   <translation>ist weder eine Datei noch eine eingebaute Umgebung%1</translation>
  </message>
  <message>
   <source>The built-in ones are %1</source>
   <translation>Eingebaut sind %1</translation>
  </message>
  <message>
   <source>is %1 × %2 texels, and such an image is square</source>
   <translation>hat %1 × %2 Texel, und ein solches Bild ist quadratisch</translation>
  </message>
  <message>
   <source>Cut it at the rim</source>
   <translation>Am Rand zuschneiden</translation>
  </message>
  <message>
   <source>is %1 × %2 texels, %3</source>
   <translation>hat %1 × %2 Texel, %3</translation>
  </message>
  <message>
   <source>holds no usable radiance: every texel is negative or not finite</source>
   <translation>enthält keine brauchbare Strahldichte: jeder Texel ist negativ oder nicht endlich</translation>
  </message>
  <message>
   <source>six faces of a cube map in a strip</source>
   <translation>sechs Flächen einer Würfelkarte in einem Streifen</translation>
  </message>
  <message>
   <source>a photograph, or a cube map laid out as a cross whose empty corners are not empty</source>
   <translation>ein Foto, oder eine Würfelkarte als Kreuz, dessen leere Ecken nicht leer sind</translation>
  </message>
  <message>
   <source>perhaps a cube map in two rows of faces, or a photograph</source>
   <translation>vielleicht eine Würfelkarte in zwei Reihen von Flächen, oder ein Foto</translation>
  </message>
  <message>
   <source>square, as mirror balls (--env ball:FILE) and angular maps (--env angular:FILE) are</source>
   <translation>quadratisch wie Spiegelkugeln (--env ball:FILE) und Winkelkarten (--env angular:FILE)</translation>
  </message>
  <message>
   <source>not an equirectangular map</source>
   <translation>keine äquirektangulare Karte</translation>
  </message>
  <message>
   <source>negative, down to %1</source>
   <translation>negativ, bis %1</translation>
  </message>
  <message>
   <source>not finite</source>
   <translation>nicht endlich</translation>
  </message>
  <message>
   <source>%1 values lie more than %2 texels inside damaged areas and are black</source>
   <translation>%1 Werte liegen mehr als %2 Texel im Inneren beschädigter Bereiche und sind schwarz</translation>
  </message>
  <message>
   <source>a %1 that holds no radiance above 1: lamps and the sun are far too dark in it</source>
   <translation>ein %1 ohne Strahldichte über 1: Lampen und Sonne sind darin viel zu dunkel</translation>
  </message>
  <message>
   <source>the environment is black</source>
   <translation>die Umgebung ist schwarz</translation>
  </message>
  <message>
   <source>column %1, row %2</source>
   <translation>Spalte %1, Zeile %2</translation>
  </message>
  <message>
   <source>%1 texel%2 %3 (at %4%5)</source>
   <translation>%1 Texel %3 (bei %4%5)</translation>
  </message>
  <message>
   <source>s are</source>
   <translation>sind</translation>
  </message>
  <message>
   <source>%1; replaced by the median of the neighbours</source>
   <translation>%1; ersetzt durch den Median der Nachbarn</translation>
  </message>
  <message>
   <source>the direction of a lamp needs three finite numbers, not all 0, got %1</source>
   <translation>die Richtung eines Lichts braucht drei endliche Zahlen, nicht alle 0; angegeben: %1</translation>
  </message>
  <message>
   <source>the irradiance of a lamp needs three numbers from 0, got %1</source>
   <translation>die Bestrahlungsstärke eines Lichts braucht drei Zahlen ab 0; angegeben: %1</translation>
  </message>
  <message>
   <source>a lamp of radius %1° is not between 0 and 90°</source>
   <translation>ein Licht mit Radius %1° liegt nicht zwischen 0 und 90°</translation>
  </message>
  <message>
   <source>Angle of the light from straight up.</source>
   <translation>Winkel des Lichts von senkrecht nach oben.</translation>
  </message>
  <message>
   <source>Turn from the viewer's side towards the right.</source>
   <translation>Drehung von der Seite des Betrachters nach rechts.</translation>
  </message>
  <message>
   <source>On a surface that faces the light.</source>
   <translation>Auf einer dem Licht zugewandten Fläche.</translation>
  </message>
  <message>
   <source>Angular radius; 0 is one direction.</source>
   <translation>Winkelradius; 0 ist eine einzige Richtung.</translation>
  </message>
  <message>
   <source>Linear RGB, times the irradiance.</source>
   <translation>Lineares RGB, mal der Bestrahlungsstärke.</translation>
  </message>
  <message>
   <source>Rectangle</source>
   <translation>Rechteck</translation>
  </message>
  <message>
   <source>Disc</source>
   <translation>Scheibe</translation>
  </message>
  <message>
   <source>the position of a lamp needs three finite numbers, got %1</source>
   <translation>die Position eines Lichts braucht drei endliche Zahlen; angegeben: %1</translation>
  </message>
  <message>
   <source>the power of a lamp needs three numbers from 0, got %1</source>
   <translation>die Leistung eines Lichts braucht drei Zahlen ab 0; angegeben: %1</translation>
  </message>
  <message>
   <source>a lamp of radius %1 is not possible</source>
   <translation>ein Licht mit Radius %1 ist nicht möglich</translation>
  </message>
  <message>
   <source>unknown shape %1; choose from %2</source>
   <translation>unbekannte Form %1; möglich: %2</translation>
  </message>
  <message>
   <source>a rectangle of %1 is not possible; its sides are at least %2</source>
   <translation>ein Rechteck von %1 ist nicht möglich; seine Seiten sind mindestens %2</translation>
  </message>
  <message>
   <source>the width of a lamp needs a direction of three finite numbers, got %1</source>
   <translation>die Breite eines Lichts braucht eine Richtung aus drei endlichen Zahlen; angegeben: %1</translation>
  </message>
  <message>
   <source>A sphere, or one side of a rectangle or a disc.</source>
   <translation>Eine Kugel oder eine Seite eines Rechtecks oder einer Scheibe.</translation>
  </message>
  <message>
   <source>Where its centre is, in the model's own coordinates.</source>
   <translation>Wo ihr Mittelpunkt ist, in den Koordinaten des Modells.</translation>
  </message>
  <message>
   <source>Upwards.</source>
   <translation>Nach oben.</translation>
  </message>
  <message>
   <source>Towards the viewer.</source>
   <translation>Zum Betrachter.</translation>
  </message>
  <message>
   <source>Radius of the sphere or the disc; 0 is a point.</source>
   <translation>Radius der Kugel oder Scheibe; 0 ist ein Punkt.</translation>
  </message>
  <message>
   <source>Width of the rectangle.</source>
   <translation>Breite des Rechtecks.</translation>
  </message>
  <message>
   <source>Height of the rectangle.</source>
   <translation>Höhe des Rechtecks.</translation>
  </message>
  <message>
   <source>Direction it faces: angle from straight up.</source>
   <translation>Blickrichtung: Winkel von senkrecht nach oben.</translation>
  </message>
  <message>
   <source>Direction it faces: turn from +Z towards +X.</source>
   <translation>Blickrichtung: Drehung von +Z nach +X.</translation>
  </message>
  <message>
   <source>Turn of the rectangle about the direction it faces.</source>
   <translation>Drehung des Rechtecks um seine Blickrichtung.</translation>
  </message>
  <message>
   <source>Irradiance at distance d: power / (4 π d²); rectangle and disc power / (π d²).</source>
   <translation>Bestrahlungsstärke im Abstand d: Leistung / (4 π d²); Rechteck und Scheibe Leistung / (π d²).</translation>
  </message>
  <message>
   <source>Linear RGB, times the power.</source>
   <translation>Lineares RGB, mal der Leistung.</translation>
  </message>
  <message>
   <source>a %1 has no %2; it has %3</source>
   <translation>%1 hat kein %2, sondern %3</translation>
  </message>
  <message>
   <source>Studio</source>
   <translation>Studio</translation>
  </message>
  <message>
   <source>Clear sky, sun at 60°</source>
   <translation>Klarer Himmel, Sonne bei 60°</translation>
  </message>
  <message>
   <source>Clear sky, sun at 30°</source>
   <translation>Klarer Himmel, Sonne bei 30°</translation>
  </message>
  <message>
   <source>Clear sky, sun at 10°</source>
   <translation>Klarer Himmel, Sonne bei 10°</translation>
  </message>
  <message>
   <source>Sunset, sun at 2°</source>
   <translation>Sonnenuntergang, Sonne bei 2°</translation>
  </message>
  <message>
   <source>Overcast sky</source>
   <translation>Bedeckter Himmel</translation>
  </message>
  <message>
   <source>Three softboxes</source>
   <translation>Drei Softboxen</translation>
  </message>
  <message>
   <source>Ring light</source>
   <translation>Ringlicht</translation>
  </message>
  <message>
   <source>Strip lights</source>
   <translation>Lichtleisten</translation>
  </message>
  <message>
   <source>Room with a window</source>
   <translation>Raum mit Fenster</translation>
  </message>
 </context>
 <context>
  <name>engine/texel</name>
 </context>
 <context>
  <name>engine/capture</name>
  <message>
   <source>, waiting for %1</source>
   <translation>, wartet auf %1</translation>
  </message>
  <message>
   <source>is empty</source>
   <translation>ist leer</translation>
  </message>
  <message>
   <source>Copy it again</source>
   <translation>Noch einmal kopieren</translation>
  </message>
  <message>
   <source>has %1 × %2 px, and most have %3 × %4</source>
   <translation>hat %1 × %2 px, und die meisten haben %3 × %4</translation>
  </message>
  <message>
   <source>is the same image as %1: leave one of them out</source>
   <translation>ist dasselbe Bild wie %1: eines davon ausschließen</translation>
  </message>
  <message>
   <source>is shifted against the first photograph</source>
   <translation>ist gegen das erste Foto verschoben</translation>
  </message>
  <message>
   <source>seems shifted against the first photograph, as other light can imitate</source>
   <translation>scheint gegen das erste Foto verschoben, was anderes Licht vortäuschen kann</translation>
  </message>
  <message>
   <source>shows no lamp on the mirror sphere: %1</source>
   <translation>zeigt keine Lampe auf der Spiegelkugel: %1</translation>
  </message>
  <message>
   <source>Lit from %1 and %2 of azimuth, images</source>
   <translation>Beleuchtet aus den Azimuten %1 und %2 unterscheiden sich Bilder</translation>
  </message>
  <message>
   <source>%1 of equal mean radiance are clipped and cannot be compared</source>
   <translation>%1 gleicher mittlerer Strahldichte sind übersteuert und lassen sich nicht vergleichen</translation>
  </message>
  <message>
   <source>%1 of equal mean radiance differ by %2</source>
   <translation>%1 gleicher mittlerer Strahldichte um %2</translation>
  </message>
  <message>
   <source>%1: isotropic and of small relief, as the method assumes</source>
   <translation>%1: isotrop und mit geringem Relief, wie es das Verfahren annimmt</translation>
  </message>
  <message>
   <source>%1: relief or grain shows, and lamps from other sides will look alike</source>
   <translation>%1: Relief oder Maserung ist sichtbar, und Lampen auf anderen Seiten sehen gleich aus</translation>
  </message>
  <message>
   <source>%1: the material is not isotropic, or its relief not small. A directional material shows it; for a shading map keep the photographs of one azimuth</source>
   <translation>%1: das Material ist nicht isotrop, oder sein Relief ist nicht klein. Ein gerichtetes Material zeigt es; für eine Schattierungskarte die Fotos eines Azimuts behalten</translation>
  </message>
  <message>
   <source>Comparing azimuths</source>
   <translation>Azimute werden verglichen</translation>
  </message>
  <message>
   <source>Separating the room light</source>
   <translation>Raumlicht wird abgetrennt</translation>
  </message>
  <message>
   <source>The photographs do not decide how they were lit: another distance or intensity of the lamps, or room light, explains them as well and turns half of the normals by more than %1°. State what is known (--lamp-distance, --dark, a .lights file)</source>
   <translation>Die Fotos entscheiden nicht, wie sie beleuchtet waren: ein anderer Abstand oder andere Intensitäten der Lampen oder Raumlicht erklären sie ebenso und drehen die Hälfte der Normalen um mehr als %1°. Bekanntes angeben (--lamp-distance, --dark, eine .lights-Datei)</translation>
  </message>
  <message>
   <source>held-out error %1 → %2 levels</source>
   <translation>Fehler zurückgehaltener Fotos %1 → %2 Stufen</translation>
  </message>
  <message>
   <source>%1: normals change by up to %2°, %3</source>
   <translation>%1: Normalen ändern sich um bis zu %2°, %3</translation>
  </message>
  <message>
   <source>The photographs do not show that lamps are near: they are taken as distant</source>
   <translation>Die Fotos verraten nicht, dass Lampen nah sind: sie gelten als fern</translation>
  </message>
  <message>
   <source>any distance</source>
   <translation>jeder Abstand</translation>
  </message>
  <message>
   <source>Lamps %1 image widths away (%2 to %3)</source>
   <translation>Lampen in %1 Bildbreiten Abstand (%2 bis %3)</translation>
  </message>
  <message>
   <source>The photographs do not show that lamps differ in intensity: they are taken as equal</source>
   <translation>Die Fotos verraten keine Unterschiede in der Intensität der Lampen: sie gelten als gleich</translation>
  </message>
  <message>
   <source>Lamps of %1 to %2 of their median intensity (each ±%3)</source>
   <translation>Lampen mit %1 bis %2 ihrer mittleren Intensität (je ±%3)</translation>
  </message>
  <message>
   <source>The photographs show no room light</source>
   <translation>Die Fotos zeigen kein Raumlicht</translation>
  </message>
  <message>
   <source>Room light of %1 of a lamp (±%2) from azimuth %3°</source>
   <translation>Raumlicht von %1 einer Lampe (±%2) aus Azimut %3°</translation>
  </message>
  <message>
   <source>The photographs do not distinguish the list of lights from one that is turned by half a circle: if hills look like valleys, import again with --lights-form turned</source>
   <translation>Die Fotos unterscheiden die Lichterliste nicht von einer um einen halben Kreis gedrehten: wenn Hügel wie Täler aussehen, mit --lights-form turned neu importieren</translation>
  </message>
  <message>
   <source>Looking for motion of the camera</source>
   <translation>Bewegung der Kamera wird gesucht</translation>
  </message>
  <message>
   <source>too few texels are lit in both photographs of the pairs</source>
   <translation>in beiden Fotos der Paare sind zu wenige Texel beleuchtet</translation>
  </message>
  <message>
   <source>their brightness over each other is known to %1 only</source>
   <translation>ihr Helligkeitsverhältnis ist nur auf %1 bekannt</translation>
  </message>
  <message>
   <source>the normal equations of a texel are singular</source>
   <translation>die Normalgleichungen eines Texels sind singulär</translation>
  </message>
  <message>
   <source>95 % interval %1 to %2</source>
   <translation>95-%-Intervall %1 bis %2</translation>
  </message>
  <message>
   <source>as stated</source>
   <translation>wie angegeben</translation>
  </message>
  <message>
   <source>as estimated (%1)</source>
   <translation>geschätzt (%1)</translation>
  </message>
  <message>
   <source>; red, green, blue %1</source>
   <translation>; Rot, Grün, Blau %1</translation>
  </message>
  <message>
   <source>. They show %1 of the highlights, which was taken off</source>
   <translation>. Sie zeigen %1 der Glanzlichter; dieser Anteil wurde abgezogen</translation>
  </message>
  <message>
   <source>Crossed photographs are %1 times as bright as the diffuse part of parallel ones, %2%3%4</source>
   <translation>Gekreuzte Fotos sind %1-mal so hell wie der diffuse Anteil der parallelen, %2%3%4</translation>
  </message>
  <message>
   <source>4 stars</source>
   <translation>4 Sterne</translation>
  </message>
  <message>
   <source>3 stars</source>
   <translation>3 Sterne</translation>
  </message>
  <message>
   <source>2 stars</source>
   <translation>2 Sterne</translation>
  </message>
  <message>
   <source>1 star</source>
   <translation>1 Stern</translation>
  </message>
  <message>
   <source>Full</source>
   <translation>Voll</translation>
  </message>
  <message>
   <source>FADGI Technical Guidelines, 3rd edition, 2023: mean and 90th percentile of ΔE2000</source>
   <translation>FADGI Technical Guidelines, 3. Ausgabe, 2023: Mittel und 90. Perzentil von ΔE2000</translation>
  </message>
  <message>
   <source>Metamorfoze Preservation Imaging Guidelines 2.0, draft of 2023: mean and largest ΔE2000</source>
   <translation>Metamorfoze Preservation Imaging Guidelines 2.0, Entwurf von 2023: Mittel und Maximum von ΔE2000</translation>
  </message>
  <message>
   <source>Metamorfoze</source>
   <translation>Metamorfoze</translation>
  </message>
  <message>
   <source>white balance</source>
   <translation>Weißabgleich</translation>
  </message>
  <message>
   <source>3 × 3 matrix</source>
   <translation>3 × 3-Matrix</translation>
  </message>
  <message>
   <source>root polynomials</source>
   <translation>Wurzelpolynome</translation>
  </message>
  <message>
   <source>below all levels</source>
   <translation>unter allen Stufen</translation>
  </message>
  <message>
   <source>Colours were corrected by the chart in %1 (%2): ΔE2000 of its patches %3 → %4 in the mean, %5 → %6 at most, %7 on held-out patches; %8</source>
   <translation>Farben wurden nach der Farbtafel in %1 korrigiert (%2): ΔE2000 ihrer Felder %3 → %4 im Mittel, %5 → %6 höchstens, %7 auf zurückgehaltenen Feldern; %8</translation>
  </message>
  <message>
   <source>a chart is written to %1, not to %2</source>
   <translation>eine Farbtafel wird als %1 geschrieben, nicht als %2</translation>
  </message>
  <message>
   <source>a file without an ending</source>
   <translation>eine Datei ohne Endung</translation>
  </message>
  <message>
   <source>does not hold a chart as Lightarc writes it: %1%2</source>
   <translation>enthält keine Farbtafel, wie Lightarc sie schreibt: %1%2</translation>
  </message>
  <message>
   <source>Write it again with --write-chart</source>
   <translation>Mit --write-chart neu schreiben</translation>
  </message>
  <message>
   <source>holds a chart without a patch</source>
   <translation>enthält eine Farbtafel ohne Feld</translation>
  </message>
  <message>
   <source>Colour chart in %1</source>
   <translation>Farbtafel in %1</translation>
  </message>
  <message>
   <source>dark skin</source>
   <translation>dunkle Haut</translation>
  </message>
  <message>
   <source>light skin</source>
   <translation>helle Haut</translation>
  </message>
  <message>
   <source>blue sky</source>
   <translation>Himmelblau</translation>
  </message>
  <message>
   <source>blue flower</source>
   <translation>Blütenblau</translation>
  </message>
  <message>
   <source>bluish green</source>
   <translation>Blaugrün</translation>
  </message>
  <message>
   <source>purplish blue</source>
   <translation>Purpurblau</translation>
  </message>
  <message>
   <source>moderate red</source>
   <translation>mäßiges Rot</translation>
  </message>
  <message>
   <source>yellow green</source>
   <translation>Gelbgrün</translation>
  </message>
  <message>
   <source>orange yellow</source>
   <translation>Orangegelb</translation>
  </message>
  <message>
   <source>neutral 8</source>
   <translation>Neutral 8</translation>
  </message>
  <message>
   <source>neutral 6.5</source>
   <translation>Neutral 6,5</translation>
  </message>
  <message>
   <source>neutral 5</source>
   <translation>Neutral 5</translation>
  </message>
  <message>
   <source>neutral 3.5</source>
   <translation>Neutral 3,5</translation>
  </message>
  <message>
   <source>No photograph shows detail of less than %1 pixels: the sample is smooth there, or all are out of focus; stated errors do not count detail that is not seen</source>
   <translation>Kein Foto zeigt Details unter %1 Pixeln: Die Probe ist dort glatt, oder alle sind unscharf; angegebene Fehler zählen keine Details mit, die nicht zu sehen sind</translation>
  </message>
  <message>
   <source>unknown part %1 of the light; choose from %2</source>
   <translation>unbekannter Anteil %1 des Lichts; möglich: %2</translation>
  </message>
  <message>
   <source>Made of the whole light of the pairs: highlights of the photographs are in the map</source>
   <translation>Aus dem ganzen Licht der Paare erzeugt: Glanzlichter der Fotos sind in der Karte</translation>
  </message>
  <message>
   <source>reading the diffuse part</source>
   <translation>diffuser Anteil wird gelesen</translation>
  </message>
  <message>
   <source>Made of the diffuse part of the pairs: highlights, %1 of the light, are left to the BRDF</source>
   <translation>Aus dem diffusen Anteil der Paare erzeugt: Glanzlichter, %1 des Lichts, bleiben der BRDF überlassen</translation>
  </message>
  <message>
   <source>read from bare numbers in the file names</source>
   <translation>aus bloßen Zahlen in den Dateinamen gelesen wurden</translation>
  </message>
  <message>
   <source>assumed in the order of the file names</source>
   <translation>in der Reihenfolge der Dateinamen angenommen wurden</translation>
  </message>
  <message>
   <source>The photographs grow brighter with the elevations that were %1</source>
   <translation>Die Fotos werden mit den Elevationen heller, die %1</translation>
  </message>
  <message>
   <source>%1, as they do on an arc</source>
   <translation>%1, wie auf einem Bogen</translation>
  </message>
  <message>
   <source>the photographs do not grow brighter with the elevations that were %1</source>
   <translation>die Fotos werden nicht mit den Elevationen heller, die %1</translation>
  </message>
  <message>
   <source>%1%2; they were taken because a user said so</source>
   <translation>%1%2; auf Anweisung trotzdem verwendet</translation>
  </message>
  <message>
   <source>nothing says where the lamp stood, and %1, as they would on an arc</source>
   <translation>nichts sagt, wo die Lampe stand, und %1, wie sie es auf einem Bogen täten</translation>
  </message>
  <message>
   <source>Give the elevations in the order of the names (--angles-deg 10,20,30), add an .lp file or capture.toml, measure them on a mirror sphere (--sphere auto), estimate them (--estimate-lights), or say that these are right (--trust-angles)</source>
   <translation>Die Elevationen in der Reihenfolge der Namen angeben (--angles-deg 10,20,30), eine .lp-Datei oder capture.toml hinzufügen, sie an einer Spiegelkugel messen (--sphere auto), sie schätzen (--estimate-lights) oder sagen, dass diese stimmen (--trust-angles)</translation>
  </message>
  <message>
   <source>%1, or import the other %2 photographs without it</source>
   <translation>%1, oder die anderen %2 Fotos ohne dieses importieren</translation>
  </message>
  <message>
   <source>was excluded: it %1. %2</source>
   <translation>wurde ausgeschlossen: es %1. %2</translation>
  </message>
  <message>
   <source>, and so are %1 more of no use</source>
   <translation>, und %1 weitere sind ebenso unbrauchbar</translation>
  </message>
  <message>
   <source>%1, import the other %2 photographs without %3</source>
   <translation>%1, die anderen %2 Fotos ohne %3 importieren</translation>
  </message>
  <message>
   <source>%1, or use all of them</source>
   <translation>%1, oder alle verwenden</translation>
  </message>
  <message>
   <source>is black, with %1 of the light in its brightest pixels that the others lead to expect</source>
   <translation>ist schwarz, mit %1 des Lichts in seinen hellsten Pixeln, das die anderen erwarten lassen</translation>
  </message>
  <message>
   <source>Check that its lamp lit, and photograph it again</source>
   <translation>Prüfen, ob die Lampe leuchtete, und noch einmal fotografieren</translation>
  </message>
  <message>
   <source>is overexposed, with %1 of its lit pixels clipped where others have %2</source>
   <translation>ist überbelichtet: %1 seiner beleuchteten Pixel sind übersteuert, bei anderen %2</translation>
  </message>
  <message>
   <source>Photograph it again with a shorter exposure</source>
   <translation>Mit kürzerer Belichtung noch einmal fotografieren</translation>
  </message>
  <message>
   <source>evening out the brightness</source>
   <translation>Helligkeit wird ausgeglichen</translation>
  </message>
  <message>
   <source>changes its brightness slowly by %1 over the sample, the most of all</source>
   <translation>ändert seine Helligkeit über die Probe langsam um %1, am stärksten von allen</translation>
  </message>
  <message>
   <source>%1, which was evened out before the material was tiled</source>
   <translation>%1; das wurde vor dem Kacheln ausgeglichen</translation>
  </message>
  <message>
   <source>; no lamp does so much, as an object before a dark background does: import the material alone, by its </source>
   <translation>; so viel bewirkt keine Lampe, wohl aber ein Objekt vor dunklem Hintergrund: nur das Material importieren, durch seinen </translation>
  </message>
  <message>
   <source>framing, or leave the brightness as it is</source>
   <translation>Bildausschnitt, oder die Helligkeit lassen, wie sie ist</translation>
  </message>
  <message>
   <source>No sample of these 16-bit files is above %1: they are taken to hold %2 bits, with %3 as the white level</source>
   <translation>Kein Abtastwert dieser 16-Bit-Dateien liegt über %1: sie gelten als %2 Bit mit %3 als Weißpegel</translation>
  </message>
  <message>
   <source>EXIF orientations differ (%1 of %2 photographs have %3), as cameras that look down tag them by chance: %4 is taken for all</source>
   <translation>EXIF-Ausrichtungen unterscheiden sich (%1 von %2 Fotos haben %3), wie sie Kameras mit Blick nach unten zufällig setzen: %4 gilt für alle</translation>
  </message>
  <message>
   <source>Many samples of %1 of %2 floating-point photographs are exactly the largest value (%3), and none is above it: they are taken as clipped</source>
   <translation>Viele Abtastwerte von %1 von %2 Gleitkomma-Fotos sind genau der größte Wert (%3), und keiner liegt darüber: sie gelten als übersteuert</translation>
  </message>
  <message>
   <source>Most samples of these floating-point photographs are above their white level of 1, up to %1: where they are 8- or 16-bit levels, divide them by 255 or 65535</source>
   <translation>Die meisten Werte dieser Gleitkommafotos liegen über ihrem Weißpegel von 1, bis zu %1: Sind es 8- oder 16-Bit-Stufen, teilen Sie sie durch 255 oder 65535</translation>
  </message>
  <message>
   <source>was turned during the capture: EXIF orientation %1, and the others have %2</source>
   <translation>wurde während der Aufnahme gedreht: EXIF-Ausrichtung %1, und die anderen haben %2</translation>
  </message>
  <message>
   <source>Leave it out, or turn its pixels and remove the tag</source>
   <translation>Ausschließen, oder seine Pixel drehen und die Angabe entfernen</translation>
  </message>
  <message>
   <source>maps of the surface are made in %1; no colours lie beyond Rec.709</source>
   <translation>Karten der Oberfläche werden in %1 erzeugt; keine Farben liegen außerhalb von Rec.709</translation>
  </message>
  <message>
   <source>colours of %1 of the texels lie beyond Rec.709, by up to %2</source>
   <translation>Farben von %1 der Texel liegen außerhalb von Rec.709, um bis zu %2</translation>
  </message>
  <message>
   <source>maps of the surface clip them, unless imported with --working-space rec2020</source>
   <translation>Karten der Oberfläche beschneiden sie, sofern nicht mit --working-space rec2020 importiert</translation>
  </message>
  <message>
   <source>%1 of their largest component: %2</source>
   <translation>%1 ihrer größten Komponente: %2</translation>
  </message>
  <message>
   <source>%1 of them</source>
   <translation>%1 davon</translation>
  </message>
  <message>
   <source>%1 of their largest component; maps of the surface are made in %2, beyond which lie %3</source>
   <translation>%1 ihrer größten Komponente; Karten der Oberfläche werden in %2 erzeugt, außerhalb davon liegen %3</translation>
  </message>
  <message>
   <source>colours of %1 of the texels lie beyond Rec.709</source>
   <translation>Farben von %1 der Texel liegen außerhalb von Rec.709</translation>
  </message>
  <message>
   <source>%1: slices keep them, and a power law clips them</source>
   <translation>%1: Schichten behalten sie, ein Potenzgesetz schneidet sie ab</translation>
  </message>
  <message>
   <source>planes clip them, by up to %1 of their largest component</source>
   <translation>Ebenen beschneiden sie um bis zu %1 ihrer größten Komponente</translation>
  </message>
  <message>
   <source>shows no colour chart whose patches can be measured</source>
   <translation>zeigt keine Farbtafel, deren Felder sich messen lassen</translation>
  </message>
  <message>
   <source>Photograph a classic chart of 24 patches, wholly in the image, sharp, and neither clipped nor mirroring a lamp; name that photograph with --chart</source>
   <translation>Eine klassische Tafel mit 24 Feldern fotografieren, ganz im Bild, scharf, weder übersteuert noch mit Spiegelung einer Lampe; dieses Foto mit --chart nennen</translation>
  </message>
  <message>
   <source>unknown working space %1; choose from %2</source>
   <translation>unbekannter Arbeitsfarbraum %1; möglich: %2</translation>
  </message>
  <message>
   <source>a scale by the chart needs a photograph that shows one: give chart as well</source>
   <translation>ein Maßstab nach der Farbtafel braucht ein Foto, das eine zeigt: auch chart angeben</translation>
  </message>
  <message>
   <source>unknown calibration %1; choose from auto, none, %2</source>
   <translation>unbekannte Kalibrierung %1; möglich: auto, none, %2</translation>
  </message>
  <message>
   <source>bands %1 are not one or three, which count from 1</source>
   <translation>Kanäle %1 sind nicht einer oder drei, gezählt ab 1</translation>
  </message>
  <message>
   <source>unknown motion %1; choose from auto, none, %2</source>
   <translation>unbekannte Bewegung %1; möglich: auto, none, %2</translation>
  </message>
  <message>
   <source>unknown transfer %1; choose from auto, srgb, linear</source>
   <translation>unbekannte Übertragungsfunktion %1; möglich: auto, srgb, linear</translation>
  </message>
  <message>
   <source>crop %1 needs left and top from 0, width and height from 1</source>
   <translation>der Ausschnitt %1 braucht links und oben ab 0, Breite und Höhe ab 1</translation>
  </message>
  <message>
   <source>a crop and a framing cannot both be followed</source>
   <translation>ein Ausschnitt und ein Bildausschnitt gelten nicht zugleich</translation>
  </message>
  <message>
   <source>lamps are equalised by a white patch or by the object, not by %1</source>
   <translation>Lampen werden nach einem weißen Feld oder nach dem Objekt angeglichen, nicht nach %1</translation>
  </message>
  <message>
   <source>pair_gain %1 is not between %2 and %3</source>
   <translation>pair_gain %1 liegt nicht zwischen %2 und %3</translation>
  </message>
  <message>
   <source>lamp_distance %1 is not above half a width of the image</source>
   <translation>der Lampenabstand %1 ist nicht größer als eine halbe Bildbreite</translation>
  </message>
  <message>
   <source>Give --sphere COLUMN,ROW,RADIUS or auto as well</source>
   <translation>Auch --sphere COLUMN,ROW,RADIUS oder auto angeben</translation>
  </message>
  <message>
   <source>has no first mirror sphere that a second could add to</source>
   <translation>hat keine erste Spiegelkugel, die eine zweite ergänzen könnte</translation>
  </message>
  <message>
   <source>Reading the white balance</source>
   <translation>Weißabgleich wird gelesen</translation>
  </message>
  <message>
   <source>Each lamp was divided by its own flat field, so that all are equally bright and even over the sample</source>
   <translation>Jede Lampe wurde durch ihr eigenes Weißbild geteilt, sodass alle gleich hell und über die Probe gleichmäßig sind</translation>
  </message>
  <message>
   <source>Reading the scale</source>
   <translation>Maßstab wird gelesen</translation>
  </message>
  <message>
   <source>Reading the lens</source>
   <translation>Objektiv wird gelesen</translation>
  </message>
  <message>
   <source>does not say where the patches of the chart are in the photographs</source>
   <translation>sagt nicht, wo die Felder der Farbtafel in den Fotos liegen</translation>
  </message>
  <message>
   <source>Name a photograph that shows the chart with --chart, not a .chart file</source>
   <translation>Mit --chart ein Foto der Farbtafel angeben, keine .chart-Datei</translation>
  </message>
  <message>
   <source>does not show the scale: %1</source>
   <translation>zeigt den Maßstab nicht: %1</translation>
  </message>
  <message>
   <source>Lay it flat next to the sample</source>
   <translation>Flach neben die Probe legen</translation>
  </message>
  <message>
   <source>focal length</source>
   <translation>Brennweite</translation>
  </message>
  <message>
   <source>size of the sensor's pixels</source>
   <translation>Größe der Sensorpixel</translation>
  </message>
  <message>
   <source>State the scale, mark a known length, or show a chart</source>
   <translation>Den Maßstab angeben, eine bekannte Länge markieren oder eine Farbtafel zeigen</translation>
  </message>
  <message>
   <source>Measure the distance from the sample to the sensor and give it with --scale exif=MM</source>
   <translation>Den Abstand von der Probe zum Sensor messen und mit --scale exif=MM angeben</translation>
  </message>
  <message>
   <source>does not note the %1, from which a scale could be estimated</source>
   <translation>vermerkt %1 nicht, woraus sich ein Maßstab schätzen ließe</translation>
  </message>
  <message>
   <source> and the </source>
   <translation> und </translation>
  </message>
  <message>
   <source>Measure the distance again</source>
   <translation>Den Abstand neu messen</translation>
  </message>
  <message>
   <source>%1 mm per pixel (95 % interval %2 to %3)</source>
   <translation>%1 mm je Pixel (95-%-Intervall %2 bis %3)</translation>
  </message>
  <message>
   <source>The camera's notes suggest %1, which is not used: --scale exif takes this estimate</source>
   <translation>Die Angaben der Kamera legen %1 nahe; das wird nicht verwendet: --scale exif übernimmt diese Schätzung</translation>
  </message>
  <message>
   <source>Looking for the colour chart</source>
   <translation>Farbtafel wird gesucht</translation>
  </message>
  <message>
   <source>The file of lights states that the lamps are %1 image widths away</source>
   <translation>Die Datei der Lichter gibt an, dass die Lampen %1 Bildbreiten entfernt sind</translation>
  </message>
  <message>
   <source>The file of lights states the intensity of each lamp</source>
   <translation>Die Datei der Lichter gibt die Intensität jeder Lampe an</translation>
  </message>
  <message>
   <source>; differences that change smoothly over the lamps cannot be separated from the reflectance and stay</source>
   <translation>; Unterschiede, die sich gleichmäßig über die Lampen ändern, lassen sich vom Reflexionsgrad nicht trennen und bleiben</translation>
  </message>
  <message>
   <source>the object</source>
   <translation>das Objekt</translation>
  </message>
  <message>
   <source>the white patch</source>
   <translation>das weiße Feld</translation>
  </message>
  <message>
   <source>Lamps were equalised by %1: their intensities were %2 to %3 of the median</source>
   <translation>Lampen wurden angeglichen durch %1: ihre Intensitäten waren %2 bis %3 des Medians</translation>
  </message>
  <message>
   <source>holds frames of each lamp, and the photographs are several exposures of each</source>
   <translation>enthält Bilder jeder Lampe, und die Fotos sind mehrere Belichtungen von jeder</translation>
  </message>
  <message>
   <source>Give one frame for all, or one exposure of each light</source>
   <translation>Ein Bild für alle angeben oder eine Belichtung jedes Lichts</translation>
  </message>
  <message>
   <source>holds %1 frames for %2 photographs, with other names</source>
   <translation>enthält %1 Bilder für %2 Fotos, mit anderen Namen</translation>
  </message>
  <message>
   <source>Give one frame for each photograph, with its name or in the same order</source>
   <translation>Ein Bild für jedes Foto angeben, mit dessen Namen oder in derselben Reihenfolge</translation>
  </message>
  <message>
   <source>The lamp is near, but nothing says on which side it stood: its fall-off is corrected as if it stood on the right. State azimuth_deg in capture.toml, give an .lp file, or measure the lights on a mirror sphere</source>
   <translation>Die Lampe ist nah, aber nichts sagt, auf welcher Seite sie stand: ihr Lichtabfall wird korrigiert, als stünde sie rechts. azimuth_deg in capture.toml angeben, eine .lp-Datei angeben oder die Lichter an einer Spiegelkugel messen</translation>
  </message>
  <message>
   <source>Reading exposures</source>
   <translation>Belichtungen werden gelesen</translation>
  </message>
  <message>
   <source>holds no %1, to which the others are to be aligned</source>
   <translation>enthält kein %1, auf das die anderen ausgerichtet werden sollen</translation>
  </message>
  <message>
   <source>Name a photograph that is there, the shortest exposure of its light</source>
   <translation>Ein vorhandenes Foto nennen, die kürzeste Belichtung seines Lichts</translation>
  </message>
  <message>
   <source>gives control points for %1, to which the others are aligned</source>
   <translation>gibt Passpunkte für %1 an, auf das die anderen ausgerichtet sind</translation>
  </message>
  <message>
   <source>Remove them, or name another reference</source>
   <translation>Entfernen oder eine andere Referenz nennen</translation>
  </message>
  <message>
   <source>holds no %1, for which control points are given</source>
   <translation>enthält kein %1, für das Passpunkte angegeben sind</translation>
  </message>
  <message>
   <source>Mark points in the photographs that are there</source>
   <translation>Punkte in vorhandenen Fotos setzen</translation>
  </message>
  <message>
   <source>holds pairs under polarisers, but %1 has no crossed photograph</source>
   <translation>enthält Paare unter Polfiltern, aber %1 hat kein gekreuztes Foto</translation>
  </message>
  <message>
   <source>Add it, or take the parallel one out</source>
   <translation>Hinzufügen oder das parallele herausnehmen</translation>
  </message>
  <message>
   <source>holds no pairs under polarisers, of which a gain is stated</source>
   <translation>enthält keine Paare unter Polfiltern, für die ein Faktor angegeben ist</translation>
  </message>
  <message>
   <source>Import it without</source>
   <translation>Ohne importieren</translation>
  </message>
  <message>
   <source>%1 cannot be merged: not all exposures are known</source>
   <translation>%1 lassen sich nicht zusammenführen: nicht alle Belichtungen sind bekannt</translation>
  </message>
  <message>
   <source>State exposure_s of all photographs in capture.toml</source>
   <translation>exposure_s aller Fotos in capture.toml angeben</translation>
  </message>
  <message>
   <source>%1 has %2 × %3</source>
   <translation>%1 hat %2 × %3</translation>
  </message>
  <message>
   <source> and %1 more differ</source>
   <translation> und %1 weitere weichen ab</translation>
  </message>
  <message>
   <source>%1 of %2 photographs have %3 × %4 px, but %5%6</source>
   <translation>%1 von %2 Fotos haben %3 × %4 px, aber %5%6</translation>
  </message>
  <message>
   <source>Leave these out, or crop them to the size of the others</source>
   <translation>Ausschließen oder auf die Größe der anderen zuschneiden</translation>
  </message>
  <message>
   <source>%1 and %2 are the same image</source>
   <translation>%1 und %2 sind dasselbe Bild</translation>
  </message>
  <message>
   <source>Leave one of them out</source>
   <translation>Eines davon ausschließen</translation>
  </message>
  <message>
   <source>Colour profile %1 was applied</source>
   <translation>Farbprofil %1 wurde angewendet</translation>
  </message>
  <message>
   <source>Colours of %1 were converted to linear Rec.709 by the camera matrix of %2, without a profile</source>
   <translation>Farben von %1 wurden mit der Kameramatrix von %2 nach linearem Rec.709 umgerechnet, ohne Profil</translation>
  </message>
  <message>
   <source>Bit depths differ: %1. Each is scaled by its own white level</source>
   <translation>Bittiefen unterscheiden sich: %1. Jede wird mit ihrem eigenen Weißpegel skaliert</translation>
  </message>
  <message>
   <source>%1 bit</source>
   <translation>%1 Bit</translation>
  </message>
  <message>
   <source>Cameras differ: %1. Leave out those that do not belong</source>
   <translation>Kameras unterscheiden sich: %1. Nicht dazugehörende ausschließen</translation>
  </message>
  <message>
   <source>Transfer functions differ: %1. State transfer in capture.toml</source>
   <translation>Übertragungsfunktionen unterscheiden sich: %1. transfer in capture.toml angeben</translation>
  </message>
  <message>
   <source>Colour profiles differ: %1. Each was applied</source>
   <translation>Farbprofile unterscheiden sich: %1. Jedes wurde angewandt</translation>
  </message>
  <message>
   <source>White balances differ: %1. Give one for all with --white-balance</source>
   <translation>Weißabgleiche unterscheiden sich: %1. Einen für alle mit --white-balance angeben</translation>
  </message>
  <message>
   <source>%1 (%2 photographs, %3 first)</source>
   <translation>%1 (%2 Fotos, zuerst %3)</translation>
  </message>
  <message>
   <source>Scale: %1</source>
   <translation>Maßstab: %1</translation>
  </message>
  <message>
   <source>Read %1 of %2</source>
   <translation>%1 von %2 gelesen</translation>
  </message>
  <message>
   <source>holds pairs under polarisers of which both photographs are the same image</source>
   <translation>enthält Paare unter Polfiltern, deren beide Fotos dasselbe Bild sind</translation>
  </message>
  <message>
   <source>Give the crossed photographs</source>
   <translation>Die gekreuzten Fotos angeben</translation>
  </message>
  <message>
   <source>Reading %1 of %2</source>
   <translation>%1 von %2 wird gelesen</translation>
  </message>
  <message>
   <source>Reading %1 of %2, crossed</source>
   <translation>%1 von %2 wird gelesen, gekreuzt</translation>
  </message>
  <message>
   <source>The list of lights does not seem to belong to the photographs: it fits clearly better %1 (residual %2 → %3 of the brightness, slopes that belong to no surface %4 → %5). Nothing was changed or calibrated: import again with --lights-form %6, or correct the list</source>
   <translation>Die Lichterliste scheint nicht zu den Fotos zu gehören: sie passt deutlich besser %1 (Rest %2 → %3 der Helligkeit, Steigungen, die zu keiner Oberfläche gehören, %4 → %5). Nichts wurde geändert oder kalibriert: mit --lights-form %6 neu importieren oder die Liste berichtigen</translation>
  </message>
  <message>
   <source>. If hills then look like valleys, it is %1</source>
   <translation>. Sehen Hügel dann wie Täler aus, ist sie %1</translation>
  </message>
  <message>
   <source>coded as sRGB</source>
   <translation>als sRGB kodiert</translation>
  </message>
  <message>
   <source>The samples of the photographs seem to be %1, but were read as %2: error on photographs held out %3 → %4 levels</source>
   <translation>Die Abtastwerte der Fotos scheinen %1 zu sein, wurden aber als %2 gelesen: Fehler zurückgehaltener Fotos %3 → %4 Stufen</translation>
  </message>
  <message>
   <source>. No rig was calibrated: import again with --transfer %1, or %2 if that is right</source>
   <translation>. Es wurde kein Aufbau kalibriert: mit --transfer %1 neu importieren, oder mit %2, wenn das stimmt</translation>
  </message>
  <message>
   <source>The camera moved by up to %1 px: photographs were shifted back, %2</source>
   <translation>Die Kamera bewegte sich um bis zu %1 px: Fotos wurden zurückgeschoben, %2</translation>
  </message>
  <message>
   <source>The photographs do not show that the camera moved: they stay as they are (%1)</source>
   <translation>Die Fotos verraten keine Bewegung der Kamera: sie bleiben, wie sie sind (%1)</translation>
  </message>
  <message>
   <source>holds pairs under polarisers whose parts cannot be taken apart: %1</source>
   <translation>enthält Paare unter Polfiltern, deren Anteile sich nicht trennen lassen: %1</translation>
  </message>
  <message>
   <source>State how bright a matte white patch is in a crossed photograph over the parallel one with --pair-gain, or import the photographs as they are with --pair none</source>
   <translation>Mit --pair-gain angeben, wie hell ein mattes weißes Feld in einem gekreuzten Foto im Verhältnis zum parallelen ist, oder die Fotos mit --pair none importieren, wie sie sind</translation>
  </message>
  <message>
   <source>Calibrating</source>
   <translation>Kalibrierung</translation>
  </message>
  <message>
   <source>has control points, but is the one that the others are aligned to</source>
   <translation>hat Passpunkte, ist aber das Foto, auf das die anderen ausgerichtet werden</translation>
  </message>
  <message>
   <source>Say which photograph is the reference: reference in capture.toml</source>
   <translation>Angeben, welches Foto die Referenz ist: reference in capture.toml</translation>
  </message>
  <message>
   <source>The lights spread over %1° of azimuth, so that a directional material shows them best; a shading map, which knows their elevations alone, averages relief that is lit from several sides</source>
   <translation>Die Lichter verteilen sich über %1° Azimut, sodass ein gerichtetes Material sie am besten zeigt; eine Schattierungskarte kennt nur ihre Elevationen und mittelt Relief, das von mehreren Seiten beleuchtet ist</translation>
  </message>
  <message>
   <source>has a key of more than %1 parts</source>
   <translation>hat einen Schlüssel mit mehr als %1 Teilen</translation>
  </message>
  <message>
   <source>Correct it, or remove the file</source>
   <translation>Korrigieren oder die Datei entfernen</translation>
  </message>
  <message>
   <source>is not valid TOML (%1)</source>
   <translation>ist kein gültiges TOML (%1)</translation>
  </message>
  <message>
   <source>Correct this key, or remove the file</source>
   <translation>Diesen Schlüssel korrigieren oder die Datei entfernen</translation>
  </message>
  <message>
   <source>Thumbnails</source>
   <translation>Vorschaubilder</translation>
  </message>
  <message>
   <source>Copies, equal in every byte,</source>
   <translation>Kopien, gleich in jedem Byte,</translation>
  </message>
  <message>
   <source>Edits</source>
   <translation>Bearbeitungen</translation>
  </message>
  <message>
   <source>%1 were excluded</source>
   <translation>%1 wurden ausgeschlossen</translation>
  </message>
  <message>
   <source>Shots lie there in several kinds of files; %1 %2 taken, not</source>
   <translation>Aufnahmen liegen dort in mehreren Dateiarten; verwendet: %1, nicht</translation>
  </message>
  <message>
   <source>Not all photographs are of one kind: %1 are mixed</source>
   <translation>Die Fotos sind nicht alle von einer Art: %1 sind gemischt</translation>
  </message>
  <message>
   <source>has its lights from another source</source>
   <translation>hat seine Lichter aus einer anderen Quelle</translation>
  </message>
  <message>
   <source>Open it as a project of its own</source>
   <translation>Als eigenes Projekt öffnen</translation>
  </message>
  <message>
   <source>has pairs under polarisers, and the other photographs have none</source>
   <translation>hat Paare unter Polfiltern, und die anderen Fotos haben keine</translation>
  </message>
  <message>
   <source>Open it by itself</source>
   <translation>Allein öffnen</translation>
  </message>
  <message>
   <source>holds photographs that are there already, or that are called the same: %1</source>
   <translation>enthält Fotos, die schon da sind oder gleich heißen: %1</translation>
  </message>
  <message>
   <source>Leave them out, or give them other names</source>
   <translation>Ausschließen oder anders benennen</translation>
  </message>
  <message>
   <source>%1 and %2</source>
   <translation>%1 und %2</translation>
  </message>
  <message>
   <source>has the light of another photograph (%1, %2)</source>
   <translation>hat das Licht eines anderen Fotos (%1, %2)</translation>
  </message>
  <message>
   <source>Leave one of them out, or correct its light</source>
   <translation>Eines davon ausschließen oder sein Licht korrigieren</translation>
  </message>
  <message>
   <source>Measuring the lamp of %1 of %2</source>
   <translation>Die Lampe von %1 von %2 wird gemessen</translation>
  </message>
  <message>
   <source>does not show the white patch, or clipped</source>
   <translation>zeigt das weiße Feld nicht oder übersteuert</translation>
  </message>
  <message>
   <source>Give another patch</source>
   <translation>Ein anderes Feld angeben</translation>
  </message>
  <message>
   <source>is black</source>
   <translation>ist schwarz</translation>
  </message>
  <message>
   <source>Leave it out</source>
   <translation>Ausschließen</translation>
  </message>
  <message>
   <source>has %1 lamps, too few to separate their intensities from the reflectance of the object</source>
   <translation>hat %1 Lampen, zu wenige, um ihre Intensitäten vom Reflexionsgrad des Objekts zu trennen</translation>
  </message>
  <message>
   <source>Give a white patch (--equalise LEFT,TOP,WIDTH,HEIGHT), or %1 lamps</source>
   <translation>Ein weißes Feld (--equalise LEFT,TOP,WIDTH,HEIGHT) oder %1 Lampen angeben</translation>
  </message>
  <message>
   <source>Elevations were read from the file names</source>
   <translation>Elevationen wurden aus den Dateinamen gelesen</translation>
  </message>
  <message>
   <source>No angles were found</source>
   <translation>Keine Winkel gefunden</translation>
  </message>
  <message>
   <source>holds several light-position files: %1</source>
   <translation>enthält mehrere Dateien mit Lichtpositionen: %1</translation>
  </message>
  <message>
   <source>Keep the one that belongs</source>
   <translation>Die zugehörige behalten</translation>
  </message>
  <message>
   <source>%1 photographs, but %2 angles were given</source>
   <translation>%1 Fotos, aber %2 Winkel angegeben</translation>
  </message>
  <message>
   <source>Give one elevation in degrees per photograph, in the order of their names</source>
   <translation>Eine Elevation in Grad je Foto angeben, in der Reihenfolge der Namen</translation>
  </message>
  <message>
   <source>an elevation of %1° is outside 0° to 90°</source>
   <translation>eine Elevation von %1° liegt nicht zwischen 0° und 90°</translation>
  </message>
  <message>
   <source>The elevation of the light counts from the sample (0°) to straight above (90°)</source>
   <translation>Die Elevation des Lichts zählt von der Probe (0°) bis senkrecht darüber (90°)</translation>
  </message>
  <message>
   <source>lists %1 more than once</source>
   <translation>nennt %1 mehr als einmal</translation>
  </message>
  <message>
   <source>Keep one entry for each</source>
   <translation>Je einen Eintrag behalten</translation>
  </message>
  <message>
   <source>Add it, or the table [sphere] of a mirror sphere that shows it</source>
   <translation>Sie hinzufügen, oder die Tabelle [sphere] einer Spiegelkugel, die sie zeigt</translation>
  </message>
  <message>
   <source>gives no elevation_deg for %1</source>
   <translation>gibt kein elevation_deg für %1 an</translation>
  </message>
  <message>
   <source>%1 image widths away</source>
   <translation>%1 Bildbreiten entfernt</translation>
  </message>
  <message>
   <source>, with intensities of %1 to %2 of the median</source>
   <translation>, mit Intensitäten von %1 bis %2 des Medians</translation>
  </message>
  <message>
   <source>states the %1 lamps: %2%3</source>
   <translation>gibt die %1 Lampen an: %2%3</translation>
  </message>
  <message>
   <source>without their extensions</source>
   <translation>ohne ihre Endungen</translation>
  </message>
  <message>
   <source>by their numbers alone</source>
   <translation>nur nach ihren Nummern</translation>
  </message>
  <message>
   <source>line %1 (%2)</source>
   <translation>Zeile %1 (%2)</translation>
  </message>
  <message>
   <source>in the order of its lines</source>
   <translation>in der Reihenfolge ihrer Zeilen</translation>
  </message>
  <message>
   <source>%1 is %2</source>
   <translation>%1 ist %2</translation>
  </message>
  <message>
   <source>names other files than the photographs; they were matched %1: %2, %3. Check that this is right</source>
   <translation>nennt andere Dateien als die Fotos; sie wurden %1 zugeordnet: %2, %3. Prüfen, ob das stimmt</translation>
  </message>
  <message>
   <source>describes %1 lamps, but there are %2 photographs</source>
   <translation>beschreibt %1 Lampen, aber es gibt %2 Fotos</translation>
  </message>
  <message>
   <source>Add the photographs that are missing, or correct it</source>
   <translation>Die fehlenden Fotos hinzufügen oder sie berichtigen</translation>
  </message>
  <message>
   <source>, %1 image widths away</source>
   <translation>, %1 Bildbreiten entfernt</translation>
  </message>
  <message>
   <source>its lamps%1 were taken in the order of the file names. Check that they were lit in it</source>
   <translation>ihre Lampen%1 wurden in der Reihenfolge der Dateinamen genommen. Prüfen, ob sie in dieser leuchteten</translation>
  </message>
  <message>
   <source>names photographs that are not there: %1</source>
   <translation>nennt Fotos, die nicht da sind: %1</translation>
  </message>
  <message>
   <source>Add them, or correct it</source>
   <translation>Sie hinzufügen oder sie berichtigen</translation>
  </message>
  <message>
   <source>does not mention %1</source>
   <translation>erwähnt %1 nicht</translation>
  </message>
  <message>
   <source>Add them to it, or take them out of the folder</source>
   <translation>Sie dort eintragen oder aus dem Ordner nehmen</translation>
  </message>
  <message>
   <source>of %1 photographs, %2 has no angle in its name and the others have</source>
   <translation>von %1 Fotos hat %2 keinen Winkel im Namen, und die anderen haben einen</translation>
  </message>
  <message>
   <source>Rename it, take it out, or give all angles yourself</source>
   <translation>Es umbenennen, herausnehmen oder alle Winkel selbst angeben</translation>
  </message>
  <message>
   <source>%1: %2. Check that they are right</source>
   <translation>%1: %2. Prüfen, ob sie stimmen</translation>
  </message>
  <message>
   <source>%1: elevations from %2° to %3° in steps of %4° are assumed, in the order of the file names. Give the real ones</source>
   <translation>%1: Elevationen von %2° bis %3° in Schritten von %4° werden angenommen, in der Reihenfolge der Dateinamen. Die wirklichen angeben</translation>
  </message>
  <message>
   <source>holds %1 exposures of one light only</source>
   <translation>enthält nur %1 Belichtungen eines Lichts</translation>
  </message>
  <message>
   <source>At least two images under different lights are needed</source>
   <translation>Mindestens zwei Bilder unter verschiedenen Lichtern sind nötig</translation>
  </message>
  <message>
   <source>, azimuth %1°</source>
   <translation>, Azimut %1°</translation>
  </message>
  <message>
   <source>elevation %1°%2</source>
   <translation>Elevation %1°%2</translation>
  </message>
  <message>
   <source>%1 photographs share their direction of light with another one; each counts as a measurement</source>
   <translation>%1 Fotos teilen ihre Lichtrichtung mit einem anderen; jedes zählt als Messung</translation>
  </message>
  <message>
   <source>Every direction of light occurs twice, and each photograph counts as a measurement. If these are pairs under parallel and crossed polarisers, put each half into a folder called parallel or crossed, or give the folder of the crossed half with --pair</source>
   <translation>Jede Lichtrichtung kommt zweimal vor, und jedes Foto zählt als Messung. Falls dies Paare unter parallelen und gekreuzten Polfiltern sind, jede Hälfte in einen Ordner namens parallel oder crossed legen oder den Ordner der gekreuzten Hälfte mit --pair angeben</translation>
  </message>
  <message>
   <source>Take one of them out of the folder, correct the light that is stated for it, or state different exposure_s in capture.toml, by which they are merged</source>
   <translation>Eines davon aus dem Ordner nehmen, das angegebene Licht berichtigen oder verschiedene exposure_s in capture.toml angeben, nach denen sie zusammengeführt werden</translation>
  </message>
  <message>
   <source>%1 are said to be lit from the same direction: %2</source>
   <translation>%1 sollen aus derselben Richtung beleuchtet sein: %2</translation>
  </message>
  <message>
   <source>lights are written to %1, not to %2</source>
   <translation>Lichter werden als %1 geschrieben, nicht als %2</translation>
  </message>
  <message>
   <source>Write it again with --write-lights, or take it out of the folder</source>
   <translation>Mit --write-lights neu schreiben oder aus dem Ordner nehmen</translation>
  </message>
  <message>
   <source>does not hold lights as Lightarc writes them: %1%2</source>
   <translation>enthält keine Lichter, wie Lightarc sie schreibt: %1%2</translation>
  </message>
  <message>
   <source>should hold the number of lights</source>
   <translation>sollte die Anzahl der Lichter enthalten</translation>
  </message>
  <message>
   <source>announces %1 lights, but %2 follow</source>
   <translation>kündigt %1 Lichter an, aber %2 folgen</translation>
  </message>
  <message>
   <source>does not begin with the number of lights; each of its lines was taken for one</source>
   <translation>beginnt nicht mit der Anzahl der Lichter; jede Zeile gilt als eines</translation>
  </message>
  <message>
   <source>has a fourth number in each line, which was not used: intensities come from the photographs</source>
   <translation>hat eine vierte Zahl in jeder Zeile, die nicht verwendet wurde: Intensitäten kommen aus den Fotos</translation>
  </message>
  <message>
   <source>holds positions instead of directions; only their directions were used</source>
   <translation>enthält Positionen statt Richtungen; nur die Richtungen wurden verwendet</translation>
  </message>
  <message>
   <source>has commas between numbers and in them; write decimal points</source>
   <translation>hat Kommas zwischen Zahlen und darin; Dezimalpunkte schreiben</translation>
  </message>
  <message>
   <source>should hold a name and three numbers, not %1</source>
   <translation>sollte einen Namen und drei Zahlen enthalten, nicht %1</translation>
  </message>
  <message>
   <source>has a light at the distance %1; a direction or a position is needed</source>
   <translation>hat ein Licht im Abstand %1; eine Richtung oder Position ist nötig</translation>
  </message>
  <message>
   <source>has a light behind the sample (z = %1)</source>
   <translation>hat ein Licht hinter der Probe (z = %1)</translation>
  </message>
  <message>
   <source>names %1, as line %2 does</source>
   <translation>nennt %1, wie Zeile %2</translation>
  </message>
  <message>
   <source>line %1 %2</source>
   <translation>Zeile %1 %2</translation>
  </message>
  <message>
   <source>Correct the file, or remove it and give the angles yourself</source>
   <translation>Die Datei korrigieren oder entfernen und die Winkel selbst angeben</translation>
  </message>
  <message>
   <source>is not valid JSON</source>
   <translation>ist kein gültiges JSON</translation>
  </message>
  <message>
   <source>holds no list of directions</source>
   <translation>enthält keine Liste von Richtungen</translation>
  </message>
  <message>
   <source>has no x, y and z for lamp %1</source>
   <translation>hat kein x, y und z für Lampe %1</translation>
  </message>
  <message>
   <source>has a direction of length %1 for lamp %2</source>
   <translation>hat eine Richtung der Länge %1 für Lampe %2</translation>
  </message>
  <message>
   <source>has lamp %1 behind the sample (z = %2)</source>
   <translation>hat Lampe %1 hinter der Probe (z = %2)</translation>
  </message>
  <message>
   <source>unknown form of a list of lights %1; choose from %2, …</source>
   <translation>unbekannte Form einer Lichterliste %1; möglich: %2, …</translation>
  </message>
  <message>
   <source>has no list of lights that could be %1</source>
   <translation>hat keine Lichterliste, die %1 sein könnte</translation>
  </message>
  <message>
   <source>Leave --lights-form out, or give a list with azimuths (.lp)</source>
   <translation>--lights-form weglassen oder eine Liste mit Azimuten angeben (.lp)</translation>
  </message>
  <message>
   <source>no highlight stands out on the sphere</source>
   <translation>kein Glanzlicht hebt sich auf der Kugel ab</translation>
  </message>
  <message>
   <source>the highlight is hidden in part by what else the sphere mirrors</source>
   <translation>das Glanzlicht ist teilweise von anderem verdeckt, das die Kugel spiegelt</translation>
  </message>
  <message>
   <source>the sphere at column %1, row %2 has a radius of %3 pixels</source>
   <translation>die Kugel bei Spalte %1, Zeile %2 hat einen Radius von %3 Pixeln</translation>
  </message>
  <message>
   <source>%1, on which lights cannot be measured; %2 are needed</source>
   <translation>%1, an denen sich Lichter nicht messen lassen; %2 sind nötig</translation>
  </message>
  <message>
   <source>no sphere was found on which a highlight moves</source>
   <translation>es wurde keine Kugel gefunden, auf der sich ein Glanzlicht bewegt</translation>
  </message>
  <message>
   <source>Nelder-Mead</source>
   <translation>Nelder-Mead</translation>
  </message>
  <message>
   <source>the outline of the sphere lies outside the image</source>
   <translation>der Umriss der Kugel liegt außerhalb des Bildes</translation>
  </message>
  <message>
   <source>the highlight is cut by the border of the image</source>
   <translation>das Glanzlicht ist vom Bildrand abgeschnitten</translation>
  </message>
  <message>
   <source>the highlight lies too close to the outline: the lamp would stand below the sample</source>
   <translation>das Glanzlicht liegt zu nah am Umriss: die Lampe stünde unter der Probe</translation>
  </message>
  <message>
   <source>holds photographs under parallel and crossed polarisers, but %1 has no counterpart</source>
   <translation>enthält Fotos unter parallelen und gekreuzten Polfiltern, aber %1 hat kein Gegenstück</translation>
  </message>
  <message>
   <source>Add the counterpart, or take it out of the folder</source>
   <translation>Das Gegenstück hinzufügen oder es aus dem Ordner nehmen</translation>
  </message>
  <message>
   <source>their file names</source>
   <translation>ihren Dateinamen</translation>
  </message>
  <message>
   <source>holds %1 photographs under crossed polarisers and %2 under parallel ones</source>
   <translation>enthält %1 Fotos unter gekreuzten Polfiltern und %2 unter parallelen</translation>
  </message>
  <message>
   <source>Give one crossed photograph for each parallel one</source>
   <translation>Für jedes parallele Foto ein gekreuztes angeben</translation>
  </message>
  <message>
   <source>the folders, and equal names</source>
   <translation>den Ordnern und gleichen Namen</translation>
  </message>
  <message>
   <source>the folders, and their names</source>
   <translation>den Ordnern und ihren Namen</translation>
  </message>
  <message>
   <source>the folders, in the order of their names</source>
   <translation>den Ordnern, in der Reihenfolge ihrer Namen</translation>
  </message>
  <message>
   <source>%1 pairs under parallel and crossed polarisers were identified by %2: %3 is parallel, %4/%5 is crossed</source>
   <translation>%1 Paare unter parallelen und gekreuzten Polfiltern wurden erkannt an %2: %3 ist parallel, %4/%5 ist gekreuzt</translation>
  </message>
  <message>
   <source>%1 pairs under parallel and crossed polarisers were identified by %2: %3 is parallel, %4 is crossed</source>
   <translation>%1 Paare unter parallelen und gekreuzten Polfiltern wurden erkannt an %2: %3 ist parallel, %4 ist gekreuzt</translation>
  </message>
  <message>
   <source>azimuth %1±%2 is not within ±360° with a tolerance of 0° to 180°</source>
   <translation>Azimut %1±%2 liegt nicht innerhalb von ±360° mit einer Toleranz von 0° bis 180°</translation>
  </message>
  <message>
   <source>Of the list</source>
   <translation>Von der Liste</translation>
  </message>
  <message>
   <source>Of azimuth %1</source>
   <translation>Von Azimut %1</translation>
  </message>
  <message>
   <source>The nearest lights are at %1; widen the tolerance, or choose another azimuth</source>
   <translation>Die nächsten Lichter liegen bei %1; die Toleranz erweitern oder einen anderen Azimut wählen</translation>
  </message>
  <message>
   <source>has %1 at azimuth %2</source>
   <translation>hat %1 bei Azimut %2</translation>
  </message>
  <message>
   <source>keeps one light of the list only</source>
   <translation>behält nur ein Licht der Liste</translation>
  </message>
  <message>
   <source>At least two are needed</source>
   <translation>Mindestens zwei sind nötig</translation>
  </message>
  <message>
   <source>%1, %2 of %3 lights are used: %4</source>
   <translation>%1 werden %2 von %3 Lichtern verwendet: %4</translation>
  </message>
  <message>
   <source>Give an .lp file, azimuth_deg in capture.toml, or measure the lights on a mirror sphere</source>
   <translation>Eine .lp-Datei oder azimuth_deg in capture.toml angeben, oder die Lichter an einer Spiegelkugel messen</translation>
  </message>
  <message>
   <source>has no azimuths to choose lights by</source>
   <translation>hat keine Azimute, nach denen Lichter gewählt werden könnten</translation>
  </message>
  <message>
   <source>has lights 1 to %1, but %2 was asked for</source>
   <translation>hat Lichter 1 bis %1, aber %2 wurde verlangt</translation>
  </message>
  <message>
   <source>Count photographs in the order of their file names</source>
   <translation>Fotos in der Reihenfolge ihrer Dateinamen zählen</translation>
  </message>
  <message>
   <source>has no light called %1</source>
   <translation>hat kein Licht namens %1</translation>
  </message>
  <message>
   <source>Give file names of its photographs, or their numbers: 1,4-9</source>
   <translation>Dateinamen der Fotos angeben oder ihre Nummern: 1,4-9</translation>
  </message>
  <message>
   <source>no light</source>
   <translation>kein Licht</translation>
  </message>
  <message>
   <source>one light only</source>
   <translation>nur ein Licht</translation>
  </message>
  <message>
   <source>holds %1</source>
   <translation>enthält %1</translation>
  </message>
  <message>
   <source>Give the folder of the photographs under crossed polarisers</source>
   <translation>Den Ordner der Fotos unter gekreuzten Polfiltern angeben</translation>
  </message>
  <message>
   <source>lists other lights for %1 and %2, which are a pair under polarisers</source>
   <translation>nennt verschiedene Lichter für %1 und %2, die ein Paar unter Polfiltern sind</translation>
  </message>
  <message>
   <source>Correct the list, or import each photograph by itself with --pair none</source>
   <translation>Die Liste berichtigen oder mit --pair none jedes Foto für sich importieren</translation>
  </message>
  <message>
   <source>holds several exposures of one light (%1) in pairs under polarisers, which are not merged</source>
   <translation>enthält mehrere Belichtungen eines Lichts (%1) in Paaren unter Polfiltern; sie werden nicht zusammengeführt</translation>
  </message>
  <message>
   <source>Keep one exposure of each light and polariser</source>
   <translation>Eine Belichtung je Licht und Polfilter behalten</translation>
  </message>
  <message>
   <source>holds no photographs itself, but its folders %1 do</source>
   <translation>enthält selbst keine Fotos, aber seine Ordner %1</translation>
  </message>
  <message>
   <source>Give the folder of one capture</source>
   <translation>Den Ordner einer Aufnahme angeben</translation>
  </message>
  <message>
   <source>is a stack already</source>
   <translation>ist schon ein Stapel</translation>
  </message>
  <message>
   <source>Make a material of it with lightarc shade or normals</source>
   <translation>Machen Sie mit lightarc shade oder normals ein Material daraus</translation>
  </message>
  <message>
   <source>Photographs were taken from %1</source>
   <translation>Fotos stammen aus %1</translation>
  </message>
  <message>
   <source>, light positions from %1</source>
   <translation>, Lichtpositionen aus %1</translation>
  </message>
  <message>
   <source>Check the permissions of the folder</source>
   <translation>Die Rechte des Ordners prüfen</translation>
  </message>
  <message>
   <source>a %1 file is not read; convert it to TIFF or PNG</source>
   <translation>eine %1-Datei wird nicht gelesen; in TIFF oder PNG umwandeln</translation>
  </message>
  <message>
   <source>white reference</source>
   <translation>Weißbild</translation>
  </message>
  <message>
   <source>dark frame</source>
   <translation>Dunkelbild</translation>
  </message>
  <message>
   <source>taken for a %1 by its name and %2</source>
   <translation>dem Namen nach ein %1 und %2</translation>
  </message>
  <message>
   <source>used as such</source>
   <translation>so verwendet</translation>
  </message>
  <message>
   <source>set aside</source>
   <translation>beiseitegelegt</translation>
  </message>
  <message>
   <source>names %1, which is not there</source>
   <translation>nennt %1, das nicht da ist</translation>
  </message>
  <message>
   <source>Add the file, or correct it</source>
   <translation>Die Datei hinzufügen oder korrigieren</translation>
  </message>
  <message>
   <source>one photograph only (%1)</source>
   <translation>nur ein Foto (%1)</translation>
  </message>
  <message>
   <source>no photographs</source>
   <translation>keine Fotos</translation>
  </message>
  <message>
   <source>. Set aside: %1</source>
   <translation>. Beiseitegelegt: %1</translation>
  </message>
  <message>
   <source>Check that it exists, or leave it out</source>
   <translation>Prüfen, ob es existiert, oder es weglassen</translation>
  </message>
  <message>
   <source>is not a regular file</source>
   <translation>ist keine gewöhnliche Datei</translation>
  </message>
  <message>
   <source>several photographs are called %1</source>
   <translation>mehrere Fotos heißen %1</translation>
  </message>
  <message>
   <source>Give each a name of its own</source>
   <translation>Jedem einen eigenen Namen geben</translation>
  </message>
  <message>
   <source>holds %1 files called %2</source>
   <translation>enthält %1 Dateien namens %2</translation>
  </message>
  <message>
   <source>is an archive among other files</source>
   <translation>ist ein Archiv unter anderen Dateien</translation>
  </message>
  <message>
   <source>Give one archive alone, or files and folders</source>
   <translation>Ein Archiv allein angeben, oder Dateien und Ordner</translation>
  </message>
  <message>
   <source>Photographs in other folders of %1 were excluded: %2</source>
   <translation>Fotos in anderen Ordnern von %1 wurden ausgeschlossen: %2</translation>
  </message>
  <message>
   <source>is a bundle, or holds one: no photographs</source>
   <translation>ist oder enthält ein Paket: keine Fotos</translation>
  </message>
  <message>
   <source>Open it in the window</source>
   <translation>Im Fenster öffnen</translation>
  </message>
  <message>
   <source>holds another archive (%1)</source>
   <translation>enthält ein weiteres Archiv (%1)</translation>
  </message>
  <message>
   <source>Unpack it and give the folder</source>
   <translation>Entpacken und den Ordner angeben</translation>
  </message>
  <message>
   <source>holds no photographs</source>
   <translation>enthält keine Fotos</translation>
  </message>
  <message>
   <source>Pack the photographs of one capture</source>
   <translation>Die Fotos einer Aufnahme packen</translation>
  </message>
  <message>
   <source>holds pairs under polarisers in two folders: %1</source>
   <translation>enthält Paare unter Polfiltern in zwei Ordnern: %1</translation>
  </message>
  <message>
   <source>Unpack it and give the folder, or pack them in one folder under names that end in _par and _cross</source>
   <translation>Entpacken und den Ordner angeben, oder in einem Ordner packen unter Namen, die auf _par und _cross enden</translation>
  </message>
  <message>
   <source>holds photographs in several folders: %1</source>
   <translation>enthält Fotos in mehreren Ordnern: %1</translation>
  </message>
  <message>
   <source>Pack one capture by itself</source>
   <translation>Eine Aufnahme allein packen</translation>
  </message>
  <message>
   <source>Mark it by hand in the Capture workspace or as highlight_px in capture.toml, or leave the photograph out</source>
   <translation>Es von Hand im Arbeitsbereich Aufnahme oder als highlight_px in capture.toml markieren oder das Foto ausschließen</translation>
  </message>
  <message>
   <source>Give its outline: --second-sphere COLUMN,ROW,RADIUS</source>
   <translation>Ihren Umriss angeben: --second-sphere COLUMN,ROW,RADIUS</translation>
  </message>
  <message>
   <source>shows no second sphere: %1</source>
   <translation>zeigt keine zweite Kugel: %1</translation>
  </message>
  <message>
   <source>The rays of two mirror spheres are parallel: the lamps are taken as distant</source>
   <translation>Die Strahlen zweier Spiegelkugeln sind parallel: die Lampen gelten als fern</translation>
  </message>
  <message>
   <source>Two mirror spheres show the lamps %1 image widths away (%2 to %3); %4 of %5 lights were placed so</source>
   <translation>Zwei Spiegelkugeln zeigen die Lampen %1 Bildbreiten entfernt (%2 bis %3); %4 von %5 Lichtern wurden so gesetzt</translation>
  </message>
  <message>
   <source>Looking at the sphere in %1 of %2</source>
   <translation>Kugel in %1 von %2 wird untersucht</translation>
  </message>
  <message>
   <source>is not of the size of %1, so the sphere lies elsewhere in it</source>
   <translation>hat nicht die Größe von %1, also liegt die Kugel darin anderswo</translation>
  </message>
  <message>
   <source>Mark it by hand in the Capture workspace, or give --sphere COLUMN,ROW,RADIUS or [sphere] in capture.toml</source>
   <translation>Sie von Hand im Arbeitsbereich Aufnahme markieren, oder --sphere COLUMN,ROW,RADIUS oder [sphere] in capture.toml angeben</translation>
  </message>
  <message>
   <source>the outline of the sphere lies outside the %1 × %2 px of the photographs</source>
   <translation>der Umriss der Kugel liegt außerhalb der %1 × %2 px der Fotos</translation>
  </message>
  <message>
   <source>Correct the outline of the sphere</source>
   <translation>Den Umriss der Kugel korrigieren</translation>
  </message>
  <message>
   <source>%1 (the sphere is at %2)</source>
   <translation>%1 (die Kugel liegt bei %2)</translation>
  </message>
  <message>
   <source>column %1, row %2, radius %3 px</source>
   <translation>Spalte %1, Zeile %2, Radius %3 px</translation>
  </message>
  <message>
   <source>its light is measured at %1° on the sphere, but said to be at %2°; the measured one is used</source>
   <translation>sein Licht ist auf der Kugel bei %1° gemessen, aber mit %2° angegeben; das gemessene gilt</translation>
  </message>
  <message>
   <source>Estimating the lights</source>
   <translation>Lichter werden geschätzt</translation>
  </message>
  <message>
   <source>does not show where its lamps stood: %1</source>
   <translation>verrät nicht, wo seine Lampen standen: %1</translation>
  </message>
  <message>
   <source>Give a list of lights (.lp)</source>
   <translation>Eine Liste der Lichter angeben (.lp)</translation>
  </message>
  <message>
   <source>The lights were estimated from the photographs alone, to %1° (1 sigma), as those of equally bright distant lamps over a matte sample that lies flat</source>
   <translation>Die Lichter wurden allein aus den Fotos geschätzt, auf %1° (1 Sigma), als die gleich heller, ferner Lampen über einer matten, flach liegenden Probe</translation>
  </message>
  <message>
   <source>. Hills and valleys were distinguished by assumption: the sample bulges towards the camera; if it is hollow, all slopes are reversed</source>
   <translation>. Hügel und Täler wurden durch Annahme unterschieden: die Probe wölbt sich zur Kamera; ist sie hohl, sind alle Steigungen umgekehrt</translation>
  </message>
  <message>
   <source>%1 photographs are fewer than the %2 from which lamps can be estimated</source>
   <translation>%1 Fotos sind weniger als die %2, aus denen sich Lampen schätzen lassen</translation>
  </message>
  <message>
   <source>too few texels are lit</source>
   <translation>zu wenige Texel sind beleuchtet</translation>
  </message>
  <message>
   <source>some of them show too little</source>
   <translation>einige zeigen zu wenig</translation>
  </message>
  <message>
   <source>the lamps that would explain them stand behind the sample</source>
   <translation>die Lampen, die sie erklären würden, stehen hinter der Probe</translation>
  </message>
  <message>
   <source>the directions would be uncertain by %1°</source>
   <translation>die Richtungen wären um %1° unsicher</translation>
  </message>
  <message>
   <source>the lamps stand at one elevation or in one plane</source>
   <translation>die Lampen stehen auf einer Elevation oder in einer Ebene</translation>
  </message>
  <message>
   <source>no lamps of equal brightness explain them</source>
   <translation>keine Lampen gleicher Helligkeit erklären sie</translation>
  </message>
  <message>
   <source>holds a damaged mask</source>
   <translation>enthält eine beschädigte Maske</translation>
  </message>
  <message>
   <source>the outline of the object leaves nothing of the photographs; draw it around the object</source>
   <translation>der Umriss des Objekts lässt nichts von den Fotos übrig; um das Objekt zeichnen</translation>
  </message>
  <message>
   <source>is a mask of %1 pixels for photographs of %2</source>
   <translation>ist eine Maske von %1 Pixeln für Fotos von %2</translation>
  </message>
  <message>
   <source>Draw the mask on one of the photographs</source>
   <translation>Die Maske auf eines der Fotos zeichnen</translation>
  </message>
  <message>
   <source>is a mask that leaves nothing of the photographs</source>
   <translation>ist eine Maske, die nichts von den Fotos übrig lässt</translation>
  </message>
  <message>
   <source>Draw the object white</source>
   <translation>Das Objekt weiß zeichnen</translation>
  </message>
  <message>
   <source>an outline of %1 points is not possible (3 … %2)</source>
   <translation>ein Umriss aus %1 Punkten ist nicht möglich (3 … %2)</translation>
  </message>
  <message>
   <source>an outline has a point that is no place in a photograph</source>
   <translation>ein Umriss hat einen Punkt, der keine Stelle in einem Foto ist</translation>
  </message>
  <message>
   <source>A tile shows all of the sample: the mask of the object is not used</source>
   <translation>Eine Kachel zeigt die ganze Probe: die Maske des Objekts wird nicht verwendet</translation>
  </message>
  <message>
   <source>leaving the background out</source>
   <translation>Hintergrund wird ausgeschlossen</translation>
  </message>
  <message>
   <source>Fitted to the object alone, %1 of the image: the background is transparent</source>
   <translation>Nur an das Objekt angepasst, %1 des Bildes: der Hintergrund ist durchsichtig</translation>
  </message>
  <message>
   <source>Writing %1 of %2</source>
   <translation>%1 von %2 wird geschrieben</translation>
  </message>
  <message>
   <source>Measuring %1 of %2</source>
   <translation>%1 von %2 wird gemessen</translation>
  </message>
  <message>
   <source>the known length ends at %1,%2, outside the %3 × %4 px of the photographs</source>
   <translation>die bekannte Länge endet bei %1,%2, außerhalb der %3 × %4 px der Fotos</translation>
  </message>
  <message>
   <source>Give the points in pixels of the photographs, from the top left</source>
   <translation>Geben Sie die Punkte in Pixeln der Fotos an, von oben links gezählt</translation>
  </message>
  <message>
   <source>the photographs were moved so far apart that no pixel is seen by all</source>
   <translation>die Fotos wurden so weit auseinandergeschoben, dass kein Pixel in allen liegt</translation>
  </message>
  <message>
   <source>Check the control points, or leave out what does not belong</source>
   <translation>Die Passpunkte prüfen oder Unpassendes ausschließen</translation>
  </message>
  <message>
   <source>the crop %1 lies outside what all %2 × %3 px show</source>
   <translation>der Ausschnitt %1 liegt außerhalb dessen, was alle %2 × %3 px zeigen</translation>
  </message>
  <message>
   <source>Give left,top,width,height within the photographs</source>
   <translation>left,top,width,height innerhalb der Fotos angeben</translation>
  </message>
  <message>
   <source>no image can be made between these corners: %1</source>
   <translation>zwischen diesen Ecken lässt sich kein Bild erzeugen: %1</translation>
  </message>
  <message>
   <source>Move the corners, or give the size of the image</source>
   <translation>Die Ecken verschieben oder die Größe des Bildes angeben</translation>
  </message>
  <message>
   <source>the image between %1 reaches beyond what all %2 × %3 px show</source>
   <translation>das Bild zwischen %1 reicht über das hinaus, was alle %2 × %3 px zeigen</translation>
  </message>
  <message>
   <source>Move its corners inwards, or leave out the photograph that was moved most</source>
   <translation>Die Ecken nach innen rücken oder das am weitesten verschobene Foto ausschließen</translation>
  </message>
  <message>
   <source>the dark frame is %1 x %2 pixels, the flat field %3 x %4</source>
   <translation>das Dunkelbild hat %1 x %2 Pixel, das Weißbild %3 x %4</translation>
  </message>
  <message>
   <source>the flat field is not brighter than the dark frame</source>
   <translation>das Weißbild ist nicht heller als das Dunkelbild</translation>
  </message>
  <message>
   <source>has not the size of its dark frame</source>
   <translation>hat nicht die Größe seines Dunkelbilds</translation>
  </message>
  <message>
   <source>Give frames of the same camera</source>
   <translation>Bilder derselben Kamera angeben</translation>
  </message>
  <message>
   <source>has %1 × %2 px</source>
   <translation>hat %1 × %2 px</translation>
  </message>
  <message>
   <source>the lens was measured in photographs of %1 × %2 px</source>
   <translation>das Objektiv wurde in Fotos von %1 × %2 px vermessen</translation>
  </message>
  <message>
   <source>, but </source>
   <translation>, aber </translation>
  </message>
  <message>
   <source>Measure it with the same camera, in the same orientation</source>
   <translation>Mit derselben Kamera in derselben Ausrichtung messen</translation>
  </message>
  <message>
   <source>flat field</source>
   <translation>Weißbild</translation>
  </message>
  <message>
   <source>has %1, but the %2 has %3</source>
   <translation>hat %1, aber %2 hat %3</translation>
  </message>
  <message>
   <source>Give frames of the same camera, or leave them out</source>
   <translation>Bilder derselben Kamera angeben oder sie weglassen</translation>
  </message>
  <message>
   <source>Reading %1</source>
   <translation>%1 wird gelesen</translation>
  </message>
  <message>
   <source>is a flat field without light</source>
   <translation>ist ein Weißbild ohne Licht</translation>
  </message>
  <message>
   <source>Give one of an even white surface under its lamp</source>
   <translation>Eines von einer gleichmäßig weißen Fläche unter ihrer Lampe angeben</translation>
  </message>
  <message>
   <source>has not the size of the dark frame %1</source>
   <translation>hat nicht die Größe des Dunkelbilds %1</translation>
  </message>
  <message>
   <source>Give frames of the same camera, or leave one out</source>
   <translation>Bilder derselben Kamera angeben oder eines ausschließen</translation>
  </message>
  <message>
   <source>is not a usable flat field: %1</source>
   <translation>ist kein brauchbares Weißbild: %1</translation>
  </message>
  <message>
   <source>Give another, or import with --no-flat</source>
   <translation>Ein anderes angeben oder mit --no-flat importieren</translation>
  </message>
  <message>
   <source>is camera RAW, which has no bands to choose</source>
   <translation>ist Kamera-RAW und hat keine wählbaren Kanäle</translation>
  </message>
  <message>
   <source>Leave --bands out</source>
   <translation>--bands weglassen</translation>
  </message>
  <message>
   <source>is a %1 inside, not camera RAW</source>
   <translation>ist innen %1, kein Kamera-RAW</translation>
  </message>
  <message>
   <source>Exposures differ: %1. Radiance is brought to that of %2 s</source>
   <translation>Belichtungen unterscheiden sich: %1. Die Strahldichte wird auf die von %2 s gebracht</translation>
  </message>
  <message>
   <source>was exposed for %1 s, as stated or noted, which is outside %2 … %3</source>
   <translation>wurde laut Angabe oder Vermerk %1 s belichtet, was außerhalb von %2 … %3 liegt</translation>
  </message>
  <message>
   <source>State its exposure_s in capture.toml</source>
   <translation>Seine exposure_s in capture.toml angeben</translation>
  </message>
  <message>
   <source>Exposures differ: %1. Radiance is not scaled, because the exposure of %2%3 is unknown; state exposure_s in capture.toml</source>
   <translation>Belichtungen unterscheiden sich: %1. Die Strahldichte wird nicht skaliert, weil die Belichtung von %2%3 unbekannt ist; exposure_s in capture.toml angeben</translation>
  </message>
  <message>
   <source>grey patch %1 needs left and top from 0, width and height from 1</source>
   <translation>das graue Feld %1 braucht links und oben ab 0, Breite und Höhe ab 1</translation>
  </message>
  <message>
   <source>Measuring the grey patch in %1 of %2</source>
   <translation>Graues Feld in %1 von %2 wird gemessen</translation>
  </message>
  <message>
   <source>the grey patch is clipped in every photograph</source>
   <translation>das graue Feld ist in jedem Foto übersteuert</translation>
  </message>
  <message>
   <source>Pick a darker patch, or import with --white-balance none</source>
   <translation>Ein dunkleres Feld wählen</translation>
  </message>
  <message>
   <source>the grey patch is not light grey: its red, green and blue are %1</source>
   <translation>das graue Feld ist nicht hellgrau: sein Rot, Grün und Blau sind %1</translation>
  </message>
  <message>
   <source>Pick another patch</source>
   <translation>Ein anderes Feld wählen</translation>
  </message>
  <message>
   <source>the grey patch lies outside its %1 × %2 px</source>
   <translation>das graue Feld liegt außerhalb seiner %1 × %2 px</translation>
  </message>
  <message>
   <source>The lens moved points by up to %1 px, which was taken off (%2 photographs of a board, residual %3 px)</source>
   <translation>Das Objektiv verschob Punkte um bis zu %1 px; das wurde herausgerechnet (%2 Fotos eines Schachbretts, Rest %3 px)</translation>
  </message>
  <message>
   <source>Looking for the board in %1</source>
   <translation>Schachbrett in %1 wird gesucht</translation>
  </message>
  <message>
   <source>Measuring the lens</source>
   <translation>Objektiv wird gemessen</translation>
  </message>
  <message>
   <source>holds photographs of different sizes</source>
   <translation>enthält Fotos verschiedener Größe</translation>
  </message>
  <message>
   <source>Give those of one camera and lens</source>
   <translation>Fotos einer Kamera und eines Objektivs angeben</translation>
  </message>
  <message>
   <source>shows a chessboard in %1 photographs only</source>
   <translation>zeigt nur in %1 Fotos ein Schachbrett</translation>
  </message>
  <message>
   <source>Photograph a flat board of 6 × 5 squares or more, whole and sharp, in %1 tilted positions</source>
   <translation>Ein ebenes Brett mit mindestens 6 × 5 Quadraten, ganz und scharf, in %1 geneigten Lagen fotografieren</translation>
  </message>
  <message>
   <source>shows boards within %1 of the way to the corners of the image only</source>
   <translation>zeigt Bretter nur innerhalb von %1 des Wegs zu den Bildecken</translation>
  </message>
  <message>
   <source>Photograph the board near the edges of the image as well</source>
   <translation>Die Tafel auch nahe an den Bildrändern fotografieren</translation>
  </message>
  <message>
   <source>does not determine the lens: corners of the boards are %1 px from the model</source>
   <translation>bestimmt das Objektiv nicht: Ecken der Schachbretter liegen %1 px vom Modell entfernt</translation>
  </message>
  <message>
   <source>Use a flat board, sharp photographs, and one setting of focus and zoom</source>
   <translation>Eine flache Tafel, scharfe Fotos und eine einzige Einstellung von Fokus und Zoom verwenden</translation>
  </message>
  <message>
   <source>states a distortion that no lens has</source>
   <translation>nennt eine Verzeichnung, die kein Objektiv hat</translation>
  </message>
  <message>
   <source>Write it again with --write-lens</source>
   <translation>Mit --write-lens neu schreiben</translation>
  </message>
  <message>
   <source>does not hold a lens as Lightarc writes it: %1</source>
   <translation>enthält kein Objektiv, wie Lightarc es schreibt: %1</translation>
  </message>
  <message>
   <source>white level %1 is not above black level %2</source>
   <translation>der Weißpegel %1 liegt nicht über dem Schwarzpegel %2</translation>
  </message>
  <message>
   <source>is an incomplete RAW file: it has rows without data</source>
   <translation>ist eine unvollständige RAW-Datei: sie hat Zeilen ohne Daten</translation>
  </message>
  <message>
   <source>Convert it to DNG, for example with Adobe DNG Converter</source>
   <translation>In DNG umwandeln, etwa mit Adobe DNG Converter</translation>
  </message>
  <message>
   <source>has impossible levels (%1)</source>
   <translation>hat unmögliche Pegel (%1)</translation>
  </message>
  <message>
   <source>Convert it again to DNG</source>
   <translation>Neu nach DNG umwandeln</translation>
  </message>
  <message>
   <source>cannot be opened (LibRaw: %1)</source>
   <translation>lässt sich nicht öffnen (LibRaw: %1)</translation>
  </message>
  <message>
   <source>is a RAW file of a kind that LibRaw does not read</source>
   <translation>ist eine RAW-Datei einer Art, die LibRaw nicht liest</translation>
  </message>
  <message>
   <source>is a damaged RAW file (LibRaw: %1)</source>
   <translation>ist eine beschädigte RAW-Datei (LibRaw: %1)</translation>
  </message>
  <message>
   <source>is an incomplete RAW file (LibRaw: %1)</source>
   <translation>ist eine unvollständige RAW-Datei (LibRaw: %1)</translation>
  </message>
  <message>
   <source>is an incomplete RAW file: it ends before its image does</source>
   <translation>ist eine unvollständige RAW-Datei: sie endet vor ihrem Bild</translation>
  </message>
  <message>
   <source>has %1 × %2 samples only</source>
   <translation>hat nur %1 × %2 Bildpunkte</translation>
  </message>
  <message>
   <source>has a colour filter array that LibRaw does not describe</source>
   <translation>hat ein Farbfilter, das LibRaw nicht beschreibt</translation>
  </message>
  <message>
   <source>has a sensor with the colours %1, not red, green and blue</source>
   <translation>hat einen Sensor mit den Farben %1, nicht Rot, Grün und Blau</translation>
  </message>
  <message>
   <source>its last rows</source>
   <translation>seine letzten Zeilen</translation>
  </message>
  <message>
   <source>some of its rows</source>
   <translation>einige seiner Zeilen</translation>
  </message>
  <message>
   <source>is an incomplete RAW file: %1 all hold the value %2</source>
   <translation>ist eine unvollständige RAW-Datei: %1 haben alle den Wert %2</translation>
  </message>
  <message>
   <source>has unusable white balance multipliers (%1); none is applied</source>
   <translation>hat unbrauchbare Faktoren des Weißabgleichs (%1); keiner wird angewandt</translation>
  </message>
  <message>
   <source>the file</source>
   <translation>die Datei</translation>
  </message>
  <message>
   <source>has no usable colour matrix; camera colours are taken as sRGB</source>
   <translation>hat keine brauchbare Farbmatrix; die Farben der Kamera gelten als sRGB</translation>
  </message>
  <message>
   <source>Aligning %1 of %2</source>
   <translation>%1 von %2 wird ausgerichtet</translation>
  </message>
  <message>
   <source>it stays unlike what the others predict</source>
   <translation>es bleibt anders, als die übrigen vorhersagen</translation>
  </message>
  <message>
   <source>The photographs could not be aligned and stay as they were: %1</source>
   <translation>Die Fotos ließen sich nicht ausrichten und bleiben, wie sie waren: %1</translation>
  </message>
  <message>
   <source>could not be aligned and stays as it was: %1</source>
   <translation>ließ sich nicht ausrichten und bleibt, wie es war: %1</translation>
  </message>
  <message>
   <source>has too little texture, or texture in one line only, for a motion of kind %1: shifts are used instead</source>
   <translation>hat zu wenig Textur, oder Textur nur in einer Linie, für eine Bewegung der Art %1: stattdessen werden Verschiebungen verwendet</translation>
  </message>
  <message>
   <source>The photographs seem to drift by %1 px along one smooth curve from light to light, as shading lets relief seem to. This was not followed; if the camera did drift, mark control points</source>
   <translation>Die Fotos scheinen von Licht zu Licht entlang einer glatten Kurve um %1 px zu driften, wie es die Schattierung von Relief vortäuscht. Dem wurde nicht gefolgt; falls die Kamera doch driftete, Passpunkte markieren</translation>
  </message>
  <message>
   <source>The camera seems to have moved by less than can be separated from shading, which is about %1 px: the photographs stay as they were. Mark control points where it matters</source>
   <translation>Die Kamera scheint sich um weniger bewegt zu haben, als sich von der Schattierung trennen lässt, etwa %1 px: die Fotos bleiben, wie sie waren. Wo es darauf ankommt, Passpunkte markieren</translation>
  </message>
  <message>
   <source>The shifts of %1 are not determined to better than about %2 px: the camera moved, and shading seems to move relief as well. Check these, and mark control points where it matters</source>
   <translation>Die Verschiebungen von %1 sind nicht genauer als etwa %2 px bestimmt: die Kamera bewegte sich, und auch die Schattierung scheint Relief zu bewegen. Diese prüfen und, wo es darauf ankommt, Passpunkte markieren</translation>
  </message>
  <message>
   <source>repeats: a shift that differs by %1 px fits as well. The smallest was taken; check it</source>
   <translation>wiederholt sich: eine um %1 px andere Verschiebung passt ebenso. Die kleinste wurde genommen; sie prüfen</translation>
  </message>
  <message>
   <source>Aligning all together</source>
   <translation>Alle werden zusammen ausgerichtet</translation>
  </message>
  <message>
   <source>Checking the alignment</source>
   <translation>Ausrichtung wird geprüft</translation>
  </message>
  <message>
   <source>its control points do not determine a motion of kind %1: %2 was used</source>
   <translation>seine Passpunkte bestimmen keine Bewegung der Art %1: %2 wurde verwendet</translation>
  </message>
  <message>
   <source>%1 × %2 px is outside [1, %3] px</source>
   <translation>%1 × %2 px liegt außerhalb von [1, %3] px</translation>
  </message>
  <message>
   <source>a framing needs four corners of two finite numbers each</source>
   <translation>ein Bildausschnitt braucht vier Ecken aus je zwei endlichen Zahlen</translation>
  </message>
  <message>
   <source>the corners must run clockwise from the top left around a figure without dents</source>
   <translation>die Ecken müssen im Uhrzeigersinn von links oben um eine Figur ohne Einbuchtung laufen</translation>
  </message>
  <message>
   <source>three of four points lie on one line</source>
   <translation>drei von vier Punkten liegen auf einer Geraden</translation>
  </message>
  <message>
   <source>at %1 × %2 pixels they are smaller than %3 on a side</source>
   <translation>mit %1 × %2 Pixeln sind sie kleiner als %3 je Seite</translation>
  </message>
  <message>
   <source>it looks rotated by 180°</source>
   <translation>es scheint um 180° gedreht</translation>
  </message>
  <message>
   <source>no shift of up to half the frame makes it like the reference, or there is no texture</source>
   <translation>keine Verschiebung bis zur halben Bildbreite macht es der Referenz ähnlich, oder es hat keine Textur</translation>
  </message>
  <message>
   <source>it stays unlike the reference (correlation %1)</source>
   <translation>es bleibt der Referenz unähnlich (Korrelation %1)</translation>
  </message>
  <message>
   <source>its light is too unlike (correlation %1) to separate a small shift from shading</source>
   <translation>sein Licht ist zu verschieden (Korrelation %1), um eine kleine Verschiebung von Schattierung zu unterscheiden</translation>
  </message>
  <message>
   <source>the search for its position did not converge</source>
   <translation>die Suche nach seiner Lage konvergierte nicht</translation>
  </message>
  <message>
   <source>its texture does not determine its position</source>
   <translation>seine Textur bestimmt seine Lage nicht</translation>
  </message>
  <message>
   <source>the motion found is degenerate</source>
   <translation>die gefundene Bewegung ist entartet</translation>
  </message>
  <message>
   <source>the motion found moves it by more than half the frame</source>
   <translation>die gefundene Bewegung verschiebt es um mehr als die halbe Bildbreite</translation>
  </message>
  <message>
   <source>all alike</source>
   <translation>alle gleich</translation>
  </message>
  <message>
   <source>each by its own shift</source>
   <translation>jedes um seine eigene Verschiebung</translation>
  </message>
  <message>
   <source>Crossed photographs lie up to %1 px from parallel ones and were moved back, %2</source>
   <translation>Gekreuzte Fotos liegen bis zu %1 px von parallelen entfernt und wurden zurückgeschoben, %2</translation>
  </message>
  <message>
   <source>%1 of the pixels are clipped; a shorter exposure would keep them</source>
   <translation>%1 der Pixel sind übersteuert; eine kürzere Belichtung würde sie erhalten</translation>
  </message>
  <message>
   <source>%1 of the pixels are black</source>
   <translation>%1 der Pixel sind schwarz</translation>
  </message>
  <message>
   <source>Hardly a pixel is clipped or black</source>
   <translation>Kaum ein Pixel ist übersteuert oder schwarz</translation>
  </message>
  <message>
   <source>is noisy: its mean is %1 times the noise</source>
   <translation>ist verrauscht: sein Mittel ist das %1-fache des Rauschens</translation>
  </message>
  <message>
   <source>looks blurred: %1 of the usual sharpness of this stack</source>
   <translation>wirkt unscharf: %1 der üblichen Schärfe dieses Stapels</translation>
  </message>
  <message>
   <source>alignment left %1 px</source>
   <translation>die Ausrichtung ließ %1 px übrig</translation>
  </message>
  <message>
   <source>Mean radiance grows with the elevation of the light</source>
   <translation>Die mittlere Strahldichte wächst mit der Elevation des Lichts</translation>
  </message>
  <message>
   <source>Mean radiance does not grow with the elevation of the light: it falls at %1%2</source>
   <translation>Die mittlere Strahldichte wächst nicht mit der Elevation des Lichts: sie fällt bei %1%2</translation>
  </message>
  <message>
   <source>the darkest</source>
   <translation>das dunkelste</translation>
  </message>
  <message>
   <source>the brightest</source>
   <translation>das hellste</translation>
  </message>
  <message>
   <source>is predicted from the others with an error of %1 of its mean radiance</source>
   <translation>wird aus den anderen mit einem Fehler von %1 seiner mittleren Strahldichte vorhergesagt</translation>
  </message>
  <message>
   <source>%1: it is %2, and extrapolated</source>
   <translation>%1: es ist %2 und extrapoliert</translation>
  </message>
  <message>
   <source>, the worst of all</source>
   <translation>, am schlechtesten von allen</translation>
  </message>
  <message>
   <source>, the worst of those that are interpolated</source>
   <translation>, am schlechtesten der interpolierten</translation>
  </message>
  <message>
   <source>%1; a shading map, which does not know sides, predicts it</source>
   <translation>%1; eine Schattierungskarte, die keine Seiten kennt, sagt es voraus</translation>
  </message>
  <message>
   <source>by the known length</source>
   <translation>nach der bekannten Länge</translation>
  </message>
  <message>
   <source>by the chart</source>
   <translation>nach der Farbtafel</translation>
  </message>
  <message>
   <source>an estimate from the camera's notes</source>
   <translation>eine Schätzung aus den Angaben der Kamera</translation>
  </message>
  <message>
   <source>Size of the sample by its scale; ≈ where that is an estimate from the camera's notes</source>
   <translation>Größe der Probe nach ihrem Maßstab; ≈ bei einer Schätzung aus den Angaben der Kamera</translation>
  </message>
  <message>
   <source>a known length needs points more than two pixels apart, and millimetres above 0</source>
   <translation>eine bekannte Länge braucht Punkte in mehr als zwei Pixeln Abstand und Millimeter über 0</translation>
  </message>
  <message>
   <source>patches %1 mm apart are not those of a chart: give 0.1 to 1000 mm</source>
   <translation>Felder in %1 mm Abstand sind nicht die einer Tafel: 0,1 bis 1000 mm angeben</translation>
  </message>
  <message>
   <source>a sample %1 mm from the sensor is not within 10 mm to 100 m</source>
   <translation>eine Probe %1 mm vom Sensor liegt nicht zwischen 10 mm und 100 m</translation>
  </message>
  <message>
   <source>a lens of %1 mm focuses nothing nearer than %2 mm from the sensor</source>
   <translation>ein Objektiv mit %1 mm stellt nichts näher als %2 mm vom Sensor scharf</translation>
  </message>
  <message>
   <source>the chart lies obliquely: its scale differs over it by more than 12 %</source>
   <translation>die Tafel liegt schräg: ihr Maßstab ändert sich darüber um mehr als 12 %</translation>
  </message>
  <message>
   <source>%1: %2 × %3 mm</source>
   <translation>%1: %2 × %3 mm</translation>
  </message>
  <message>
   <source>%1%2 mm per texel, %3</source>
   <translation>%1%2 mm je Texel, %3</translation>
  </message>
  <message>
   <source>%1%2 × %3 mm</source>
   <translation>%1%2 × %3 mm</translation>
  </message>
  <message>
   <source>a pixel of %1 mm is not within %2 to %3 mm</source>
   <translation>ein Pixel von %1 mm liegt nicht zwischen %2 und %3 mm</translation>
  </message>
  <message>
   <source>%1° to %2°</source>
   <translation>%1° bis %2°</translation>
  </message>
  <message>
   <source>the azimuths of the lights are not known, and a file of lights needs them</source>
   <translation>die Azimute der Lichter sind unbekannt, und eine Datei der Lichter braucht sie</translation>
  </message>
  <message>
   <source>is a file, and a stack is a folder</source>
   <translation>ist eine Datei, und ein Stapel ist ein Ordner</translation>
  </message>
  <message>
   <source>Give the folder that an import has written</source>
   <translation>Geben Sie den Ordner an, den ein Import geschrieben hat</translation>
  </message>
  <message>
   <source>states a working space that is not known</source>
   <translation>nennt einen unbekannten Arbeitsfarbraum</translation>
  </message>
  <message>
   <source>Update Lightarc, or %1</source>
   <translation>Lightarc aktualisieren oder %1</translation>
  </message>
  <message>
   <source>is not a stack: it holds no %1</source>
   <translation>ist kein Stapel: %1 fehlt darin</translation>
  </message>
  <message>
   <source>Import the photographs into a stack first</source>
   <translation>Die Fotos zuerst in einen Stapel importieren</translation>
  </message>
  <message>
   <source>was made by another version</source>
   <translation>wurde von einer anderen Version erzeugt</translation>
  </message>
  <message>
   <source>imported before stacks had checksums: damaged pixels would not be noticed</source>
   <translation>importiert, bevor Stapel Prüfsummen hatten: beschädigte Pixel würden nicht bemerkt</translation>
  </message>
  <message>
   <source>imported before records of stacks were sealed: a changed record would not be noticed</source>
   <translation>importiert, bevor Angaben von Stapeln versiegelt wurden: eine geänderte Angabe würde nicht bemerkt</translation>
  </message>
  <message>
   <source>has %1 bytes instead of %2</source>
   <translation>hat %1 Bytes statt %2</translation>
  </message>
  <message>
   <source>does not hold %1 of shape %2</source>
   <translation>enthält kein %1 der Form %2</translation>
  </message>
  <message>
   <source>is damaged: the checksum of its pixels does not fit</source>
   <translation>ist beschädigt: die Prüfsumme seiner Pixel stimmt nicht</translation>
  </message>
  <message>
   <source>is not as it was written</source>
   <translation>ist nicht, wie es geschrieben wurde</translation>
  </message>
 </context>
 <context>
  <name>engine/brdf</name>
  <message>
   <source>%1 of %2 light is reflected: the colour lies outside sRGB, and displays show none</source>
   <translation>%1 des Lichts (%2) werden reflektiert: die Farbe liegt außerhalb von sRGB, und kein Bildschirm zeigt sie</translation>
  </message>
  <message>
   <source>exchanging light and viewer changes the values by %1 (RMS): the measurement is not reciprocal</source>
   <translation>vertauscht man Licht und Blick, ändern sich die Werte um %1 (RMS): die Messung ist nicht reziprok</translation>
  </message>
  <message>
   <source>light from %1° is reflected to %2: more than arrives</source>
   <translation>Licht aus %1° wird zu %2 reflektiert: mehr, als ankommt</translation>
  </message>
  <message>
   <source>held-out samples are missed by %1 (RMS): highlights are narrower than the distance between samples</source>
   <translation>zurückgehaltene Abtastungen werden um %1 (RMS) verfehlt: Glanzlichter sind schmaler als der Abstand der Abtastungen</translation>
  </message>
  <message>
   <source>unknown BRDF %1%2; choose from %3</source>
   <translation>unbekannte BRDF %1%2; möglich: %3</translation>
  </message>
  <message>
   <source>a preset takes no other parameters; write model:preset=name or model:name=value,…</source>
   <translation>eine Voreinstellung nimmt keine weiteren Parameter; model:preset=name oder model:name=value,… schreiben</translation>
  </message>
  <message>
   <source>%1 (before %2)</source>
   <translation>%1 (vorher %2)</translation>
  </message>
  <message>
   <source>all parameters are fixed, so that nothing is left to fit</source>
   <translation>alle Parameter sind fest, sodass nichts anzupassen bleibt</translation>
  </message>
  <message>
   <source>Lambert</source>
   <translation>Lambert</translation>
  </message>
  <message>
   <source>Fraction of the light that is reflected.</source>
   <translation>Anteil des reflektierten Lichts.</translation>
  </message>
  <message>
   <source>Oren–Nayar</source>
   <translation>Oren–Nayar</translation>
  </message>
  <message>
   <source>Reflectance of the facets.</source>
   <translation>Reflexionsgrad der Facetten.</translation>
  </message>
  <message>
   <source>Standard deviation of the facets' slope angle.</source>
   <translation>Standardabweichung der Neigungswinkel der Facetten.</translation>
  </message>
  <message>
   <source>Above 1 the lobe is higher than a cosine's.</source>
   <translation>Über 1 ist die Keule höher als die eines Kosinus.</translation>
  </message>
  <message>
   <source>Lafortune</source>
   <translation>Lafortune</translation>
  </message>
  <message>
   <source>Diffuse reflectance.</source>
   <translation>Diffuser Reflexionsgrad.</translation>
  </message>
  <message>
   <source>Strength of the highlight.</source>
   <translation>Stärke des Glanzlichts.</translation>
  </message>
  <message>
   <source>Weight along the surface; negative is forward, positive back.</source>
   <translation>Gewicht längs der Fläche; negativ ist vorwärts, positiv zurück.</translation>
  </message>
  <message>
   <source>Weight along the normal; only its ratio to the other counts.</source>
   <translation>Gewicht längs der Normalen; nur das Verhältnis zum anderen zählt.</translation>
  </message>
  <message>
   <source>Sharpness of the highlight.</source>
   <translation>Schärfe des Glanzlichts.</translation>
  </message>
  <message>
   <source>Lafortune, three lobes</source>
   <translation>Lafortune, drei Keulen</translation>
  </message>
  <message>
   <source>First lobe along the surface. %1</source>
   <translation>Erste Keule längs der Fläche. %1</translation>
  </message>
  <message>
   <source>First lobe along the normal. %1</source>
   <translation>Erste Keule längs der Normalen. %1</translation>
  </message>
  <message>
   <source>Sharpness of the first lobe.</source>
   <translation>Schärfe der ersten Keule.</translation>
  </message>
  <message>
   <source>Second lobe along the surface. %1</source>
   <translation>Zweite Keule längs der Fläche. %1</translation>
  </message>
  <message>
   <source>Second lobe along the normal. %1</source>
   <translation>Zweite Keule längs der Normalen. %1</translation>
  </message>
  <message>
   <source>Sharpness of the second lobe.</source>
   <translation>Schärfe der zweiten Keule.</translation>
  </message>
  <message>
   <source>Third lobe along the surface. %1</source>
   <translation>Dritte Keule längs der Fläche. %1</translation>
  </message>
  <message>
   <source>Third lobe along the normal. %1</source>
   <translation>Dritte Keule längs der Normalen. %1</translation>
  </message>
  <message>
   <source>Sharpness of the third lobe.</source>
   <translation>Schärfe der dritten Keule.</translation>
  </message>
  <message>
   <source>Cook–Torrance</source>
   <translation>Cook–Torrance</translation>
  </message>
  <message>
   <source>Root mean square slope of the facets.</source>
   <translation>Quadratischer Mittelwert der Steigung der Facetten.</translation>
  </message>
  <message>
   <source>Reflectance of the facets at normal incidence.</source>
   <translation>Reflexionsgrad der Facetten bei senkrechtem Einfall.</translation>
  </message>
  <message>
   <source>Width of the highlight.</source>
   <translation>Breite des Glanzlichts.</translation>
  </message>
  <message>
   <source>Reflectance at normal incidence.</source>
   <translation>Reflexionsgrad bei senkrechtem Einfall.</translation>
  </message>
  <message>
   <source>GGX, anisotropic</source>
   <translation>GGX, anisotrop</translation>
  </message>
  <message>
   <source>Width along the tangent.</source>
   <translation>Breite längs der Tangente.</translation>
  </message>
  <message>
   <source>Width across the tangent.</source>
   <translation>Breite quer zur Tangente.</translation>
  </message>
  <message>
   <source>Metallic–roughness (glTF)</source>
   <translation>Metallisch–Rauheit (glTF)</translation>
  </message>
  <message>
   <source>Colour of the diffuse part, or of the metal.</source>
   <translation>Farbe des diffusen Anteils oder des Metalls.</translation>
  </message>
  <message>
   <source>0 for dielectrics, 1 for metals.</source>
   <translation>0 für Nichtleiter, 1 für Metalle.</translation>
  </message>
  <message>
   <source>Root of the width of the highlight.</source>
   <translation>Wurzel der Breite des Glanzlichts.</translation>
  </message>
  <message>
   <source>Share of the light scattered again between facets that is added: 0 in glTF, 1 in full.</source>
   <translation>Anteil des zwischen Facetten mehrfach gestreuten Lichts, der hinzukommt: 0 in glTF, 1 ganz.</translation>
  </message>
  <message>
   <source>Coverage of the clear coat.</source>
   <translation>Deckung des Klarlacks.</translation>
  </message>
  <message>
   <source>Root of the width of the coat's highlight.</source>
   <translation>Wurzel der Breite des Glanzlichts des Lacks.</translation>
  </message>
  <message>
   <source>Colour of the sheen.</source>
   <translation>Farbe des Sheens.</translation>
  </message>
  <message>
   <source>Roughness of the sheen.</source>
   <translation>Rauheit des Sheens.</translation>
  </message>
  <message>
   <source>Ward</source>
   <translation>Ward</translation>
  </message>
  <message>
   <source>Ashikhmin–Shirley</source>
   <translation>Ashikhmin–Shirley</translation>
  </message>
  <message>
   <source>Diffuse reflectance under the highlight.</source>
   <translation>Diffuser Reflexionsgrad unter dem Glanzlicht.</translation>
  </message>
  <message>
   <source>Reflectance of the highlight at normal incidence.</source>
   <translation>Reflexionsgrad des Glanzlichts bei senkrechtem Einfall.</translation>
  </message>
  <message>
   <source>Sharpness along the tangent.</source>
   <translation>Schärfe längs der Tangente.</translation>
  </message>
  <message>
   <source>Sharpness across the tangent.</source>
   <translation>Schärfe quer zur Tangente.</translation>
  </message>
  <message>
   <source>Factor on the diffuse and the metallic base.</source>
   <translation>Faktor auf die diffuse und die metallische Grundschicht.</translation>
  </message>
  <message>
   <source>Roughness of the diffuse part.</source>
   <translation>Rauheit des diffusen Anteils.</translation>
  </message>
  <message>
   <source>Factor on the reflectance of the facets.</source>
   <translation>Faktor auf den Reflexionsgrad der Facetten.</translation>
  </message>
  <message>
   <source>Tint of dielectric highlights, and of metals at 82 degrees.</source>
   <translation>Tönung der Glanzlichter von Nichtleitern und der von Metallen bei 82 Grad.</translation>
  </message>
  <message>
   <source>Index of refraction of the dielectric base.</source>
   <translation>Brechzahl der nichtleitenden Grundschicht.</translation>
  </message>
  <message>
   <source>Colour that the coat lets through.</source>
   <translation>Farbe, die der Lack durchlässt.</translation>
  </message>
  <message>
   <source>Index of refraction of the coat.</source>
   <translation>Brechzahl des Lacks.</translation>
  </message>
  <message>
   <source>Share of the darkening by light that the coat sends back.</source>
   <translation>Anteil der Abdunkelung durch Licht, das der Lack zurückwirft.</translation>
  </message>
  <message>
   <source>Coverage of the fuzz: fibres, or dust.</source>
   <translation>Deckung des Flaums: Fasern oder Staub.</translation>
  </message>
  <message>
   <source>Colour of the fuzz.</source>
   <translation>Farbe des Flaums.</translation>
  </message>
  <message>
   <source>Roughness of the fuzz.</source>
   <translation>Rauheit des Flaums.</translation>
  </message>
  <message>
   <source>Coverage of a thin film on the base.</source>
   <translation>Deckung eines dünnen Films auf der Grundschicht.</translation>
  </message>
  <message>
   <source>Thickness of the film.</source>
   <translation>Dicke des Films.</translation>
  </message>
  <message>
   <source>Index of refraction of the film.</source>
   <translation>Brechzahl des Films.</translation>
  </message>
  <message>
   <source>OpenPBR, anisotropic</source>
   <translation>OpenPBR, anisotrop</translation>
  </message>
  <message>
   <source>How far the highlight is drawn out.</source>
   <translation>Wie stark das Glanzlicht gestreckt ist.</translation>
  </message>
  <message>
   <source>The same for that of the coat.</source>
   <translation>Dasselbe für das des Lacks.</translation>
  </message>
  <message>
   <source>From the tangent to x, anticlockwise.</source>
   <translation>Von der Tangente zu x, gegen den Uhrzeigersinn.</translation>
  </message>
  <message>
   <source>Phong</source>
   <translation>Phong</translation>
  </message>
  <message>
   <source>Poulin–Fournier</source>
   <translation>Poulin–Fournier</translation>
  </message>
  <message>
   <source>Diffuse reflectance of cylinders and floor.</source>
   <translation>Diffuser Reflexionsgrad von Zylindern und Boden.</translation>
  </message>
  <message>
   <source>Strength of their highlight.</source>
   <translation>Stärke ihres Glanzlichts.</translation>
  </message>
  <message>
   <source>Sharpness of their highlight.</source>
   <translation>Schärfe ihres Glanzlichts.</translation>
  </message>
  <message>
   <source>Distance of the axes in radii; at 2 the cylinders touch.</source>
   <translation>Abstand der Achsen in Radien; bei 2 berühren sich die Zylinder.</translation>
  </message>
  <message>
   <source>Height of the floor above the axes in radii; at 1 it hides the cylinders.</source>
   <translation>Höhe des Bodens über den Achsen in Radien; bei 1 verdeckt er die Zylinder.</translation>
  </message>
  <message>
   <source>%1 has no presets; those of lafortune are the only ones</source>
   <translation>%1 hat keine Voreinstellungen; nur lafortune hat welche</translation>
  </message>
  <message>
   <source>unknown preset %1 of %2; choose from %3%4</source>
   <translation>unbekannte Voreinstellung %1 von %2; möglich: %3%4</translation>
  </message>
  <message>
   <source>the linear error grows from %1 to %2</source>
   <translation>der lineare Fehler wächst von %1 auf %2</translation>
  </message>
  <message>
   <source>%1 while the logarithmic one falls: highlights are worse than before</source>
   <translation>%1, während der logarithmische sinkt: Glanzlichter sind schlechter als zuvor</translation>
  </message>
  <message>
   <source>the logarithmic error grows from %1 to %2</source>
   <translation>der logarithmische Fehler wächst von %1 auf %2</translation>
  </message>
  <message>
   <source>%1 while the linear one falls: dim values are worse than before</source>
   <translation>%1, während der lineare sinkt: dunkle Werte sind schlechter als zuvor</translation>
  </message>
  <message>
   <source>the fit misses the values by %1 (RMS): its highlights are not those of the data</source>
   <translation>die Anpassung verfehlt die Werte um %1 (RMS): ihre Glanzlichter sind nicht die der Daten</translation>
  </message>
  <message>
   <source>is ALTA's binary form</source>
   <translation>ist die Binärform von ALTA</translation>
  </message>
  <message>
   <source>Convert it to text with ALTA's data2data</source>
   <translation>Mit data2data von ALTA in Text umwandeln</translation>
  </message>
  <message>
   <source>names unknown coordinates %1; choose from %2</source>
   <translation>nennt unbekannte Koordinaten %1; möglich: %2</translation>
  </message>
  <message>
   <source>names %1, which has %2 coordinates, but #DIM says %3</source>
   <translation>nennt %1 mit %2 Koordinaten, aber #DIM sagt %3</translation>
  </message>
  <message>
   <source>%1 does not fix both directions; the missing angles are taken as ALTA takes them</source>
   <translation>%1 legt nicht beide Richtungen fest; die fehlenden Winkel gelten wie bei ALTA</translation>
  </message>
  <message>
   <source>ALTA samples</source>
   <translation>ALTA-Abtastungen</translation>
  </message>
  <message>
   <source>has no line #DIM with its dimensions</source>
   <translation>hat keine Zeile #DIM mit seinen Dimensionen</translation>
  </message>
  <message>
   <source>has %1 where two dimensions are needed</source>
   <translation>hat %1, wo zwei Dimensionen nötig sind</translation>
  </message>
  <message>
   <source>says %1 values per sample; 1 (grey) or 3 (colour) are read</source>
   <translation>nennt %1 Werte je Abtastung; gelesen werden 1 (Grau) oder 3 (Farbe)</translation>
  </message>
  <message>
   <source>has %1 values where %2 are needed</source>
   <translation>hat %1 Werte, wo %2 nötig sind</translation>
  </message>
  <message>
   <source>names unknown values %1; choose from %2</source>
   <translation>nennt unbekannte Werte %1; möglich: %2</translation>
  </message>
  <message>
   <source>should begin with the number of wavelengths</source>
   <translation>sollte mit der Anzahl der Wellenlängen beginnen</translation>
  </message>
  <message>
   <source>announces %1 wavelengths; 1 to %2 are possible</source>
   <translation>kündigt %1 Wellenlängen an; möglich sind 1 bis %2</translation>
  </message>
  <message>
   <source>ends a list of %1 wavelengths, but %2 are announced</source>
   <translation>beendet eine Liste von %1 Wellenlängen, aber %2 sind angekündigt</translation>
  </message>
  <message>
   <source>Cornell table</source>
   <translation>Cornell-Tabelle</translation>
  </message>
  <message>
   <source>ends within a row: %1 values of %2</source>
   <translation>endet in einer Zeile: %1 Werte von %2</translation>
  </message>
  <message>
   <source>has no line VARS that names its columns</source>
   <translation>hat keine Zeile VARS, die seine Spalten nennt</translation>
  </message>
  <message>
   <source>has %1 values where VARS names %2</source>
   <translation>hat %1 Werte, wo VARS %2 nennt</translation>
  </message>
  <message>
   <source>ASTM E1392 table</source>
   <translation>ASTM-E1392-Tabelle</translation>
  </message>
  <message>
   <source>names %1 columns; at most %2 are possible</source>
   <translation>nennt %1 Spalten; möglich sind höchstens %2</translation>
  </message>
  <message>
   <source>names %1 %2 times; once is needed</source>
   <translation>nennt %1 %2-mal; einmal ist nötig</translation>
  </message>
  <message>
   <source>names %1 columns of values; 1 to %2 are possible</source>
   <translation>nennt %1 Spalten mit Werten; möglich sind 1 bis %2</translation>
  </message>
  <message>
   <source>names a column %1; wavelengths as 400nm, R,G,B, X,Y,Z or one value are read</source>
   <translation>nennt eine Spalte %1; gelesen werden Wellenlängen wie 400nm, R,G,B, X,Y,Z oder ein Wert</translation>
  </message>
  <message>
   <source>has %1 where the number of points is needed</source>
   <translation>hat %1, wo die Anzahl der Punkte nötig ist</translation>
  </message>
  <message>
   <source>announces %1 points, but %2 follow</source>
   <translation>kündigt %1 Punkte an, aber %2 folgen</translation>
  </message>
  <message>
   <source>has wavelengths that do not rise</source>
   <translation>hat Wellenlängen, die nicht steigen</translation>
  </message>
  <message>
   <source>has directions but no values R,G,B</source>
   <translation>hat Richtungen, aber keine Werte R,G,B</translation>
  </message>
  <message>
   <source>Add the columns R, G, B in 1/sr</source>
   <translation>Die Spalten R, G, B in 1/sr hinzufügen</translation>
  </message>
  <message>
   <source>no angle is above 6.3; this file is read in degrees, but looks like radians</source>
   <translation>kein Winkel ist über 6,3; diese Datei wird in Grad gelesen, sieht aber nach Radiant aus</translation>
  </message>
  <message>
   <source>CSV samples</source>
   <translation>CSV-Abtastungen</translation>
  </message>
  <message>
   <source>has an angle that is not finite in row %1</source>
   <translation>hat in Zeile %1 einen Winkel, der nicht endlich ist</translation>
  </message>
  <message>
   <source>Give all angles in degrees</source>
   <translation>Alle Winkel in Grad angeben</translation>
  </message>
  <message>
   <source>holds no measurement</source>
   <translation>enthält keine Messung</translation>
  </message>
  <message>
   <source>has %1 = %2 degrees</source>
   <translation>hat %1 = %2 Grad</translation>
  </message>
  <message>
   <source>says that %1 is in radians</source>
   <translation>gibt %1 in Radiant an</translation>
  </message>
  <message>
   <source>Write degrees</source>
   <translation>Grad schreiben</translation>
  </message>
  <message>
   <source>4 angles and 0, 1 or 3 values</source>
   <translation>4 Winkel und 0, 1 oder 3 Werte</translation>
  </message>
  <message>
   <source>Name the columns in a first line; of CUReT's files name rbrdf.dat or abrdf.dat</source>
   <translation>Die Spalten in einer ersten Zeile nennen; von CUReTs Dateien rbrdf.dat oder abrdf.dat nennen</translation>
  </message>
  <message>
   <source>begins a column that counts the rows, where theta_i is needed</source>
   <translation>beginnt mit einer Spalte, die die Zeilen zählt, wo theta_i nötig ist</translation>
  </message>
  <message>
   <source>Write one row of %1 in degrees and R, G, B</source>
   <translation>Eine Zeile aus %1 in Grad und R, G, B schreiben</translation>
  </message>
  <message>
   <source>If these are decimal commas, write decimal points, or separate the columns by semicolons</source>
   <translation>Falls das Dezimalkommas sind, Dezimalpunkte schreiben oder die Spalten mit Semikolons trennen</translation>
  </message>
  <message>
   <source>has %1 columns where %2 are needed</source>
   <translation>hat %1 Spalten, wo %2 nötig sind</translation>
  </message>
  <message>
   <source>holds %1 materials</source>
   <translation>enthält %1 Materialien</translation>
  </message>
  <message>
   <source>has no material %1</source>
   <translation>hat kein Material %1</translation>
  </message>
  <message>
   <source>%1; their numbers are %2</source>
   <translation>%1; ihre Nummern sind %2</translation>
  </message>
  <message>
   <source>Name one, as %1#%2</source>
   <translation>Eines nennen, als %1#%2</translation>
  </message>
  <message>
   <source>red, green and blue do not lie together; read as grey</source>
   <translation>Rot, Grün und Blau liegen nicht beieinander; als Grau gelesen</translation>
  </message>
  <message>
   <source>CUReT %1</source>
   <translation>CUReT %1</translation>
  </message>
  <message>
   <source>CUReT samples</source>
   <translation>CUReT-Abtastungen</translation>
  </message>
  <message>
   <source>needs the directions of its measurements</source>
   <translation>braucht die Richtungen seiner Messungen</translation>
  </message>
  <message>
   <source>Put CUReT's table.txt next to it</source>
   <translation>CUReTs table.txt danebenlegen</translation>
  </message>
  <message>
   <source>has %1 values; theta_v phi_v theta_i phi_i are needed</source>
   <translation>hat %1 Werte; nötig sind theta_v phi_v theta_i phi_i</translation>
  </message>
  <message>
   <source>has angles that are not possible</source>
   <translation>hat unmögliche Winkel</translation>
  </message>
  <message>
   <source>Fetch CUReT's table.txt again</source>
   <translation>CUReTs table.txt neu holen</translation>
  </message>
  <message>
   <source>has %1 where the number of a material is needed</source>
   <translation>hat %1, wo die Nummer eines Materials nötig ist</translation>
  </message>
  <message>
   <source>has %1 values, but table.txt has %2 pairs of directions</source>
   <translation>hat %1 Werte, aber table.txt hat %2 Richtungspaare</translation>
  </message>
  <message>
   <source>is a second row of material %1</source>
   <translation>ist eine zweite Zeile von Material %1</translation>
  </message>
  <message>
   <source>holds values that are not numbers, or absurdly large</source>
   <translation>enthält Werte, die keine Zahlen oder unsinnig groß sind</translation>
  </message>
  <message>
   <source>holds only negative entries, which mean that nothing was measured</source>
   <translation>enthält nur negative Einträge, die bedeuten, dass nichts gemessen wurde</translation>
  </message>
  <message>
   <source>MERL table</source>
   <translation>MERL-Tabelle</translation>
  </message>
  <message>
   <source>has only %1 bytes, too few for a MERL table</source>
   <translation>hat nur %1 Bytes, zu wenige für eine MERL-Tabelle</translation>
  </message>
  <message>
   <source>looks big-endian: its bytes are swapped</source>
   <translation>sieht nach Big-Endian aus: seine Bytes sind vertauscht</translation>
  </message>
  <message>
   <source>Convert it to little-endian MERL data</source>
   <translation>In MERL-Daten in Little-Endian umwandeln</translation>
  </message>
  <message>
   <source>states %1 bins where a MERL table has 90 × 90 × 180</source>
   <translation>gibt %1 Klassen an, wo eine MERL-Tabelle 90 × 90 × 180 hat</translation>
  </message>
  <message>
   <source>Give a MERL file as published</source>
   <translation>Eine MERL-Datei angeben, wie sie veröffentlicht ist</translation>
  </message>
  <message>
   <source>has %1 bytes where a MERL table has %2</source>
   <translation>hat %1 Bytes, wo eine MERL-Tabelle %2 hat</translation>
  </message>
  <message>
   <source>is not a measured BRDF of a known format</source>
   <translation>ist keine gemessene BRDF eines bekannten Formats</translation>
  </message>
  <message>
   <source>These are read: %1</source>
   <translation>Gelesen werden: %1</translation>
  </message>
  <message>
   <source>is a BSDF of a window system in XML (WINDOW, Radiance), by Klems' patches or a tensor tree</source>
   <translation>ist eine BSDF eines Fenstersystems in XML (WINDOW, Radiance), mit Klems-Feldern oder Tensorbaum</translation>
  </message>
  <message>
   <source>Sample it with Radiance's bsdfquery into a table of angles and colours (.csv)</source>
   <translation>Mit bsdfquery von Radiance in eine Tabelle von Winkeln und Farben (.csv) abtasten</translation>
  </message>
  <message>
   <source>is a BSDF of Zemax</source>
   <translation>ist eine BSDF von Zemax</translation>
  </message>
  <message>
   <source>Write its values as a table of angles and colours (.csv)</source>
   <translation>Seine Werte als Tabelle von Winkeln und Farben (.csv) schreiben</translation>
  </message>
  <message>
   <source>is an AxF file of X-Rite, or another of HDF5</source>
   <translation>ist eine AxF-Datei von X-Rite oder eine andere mit HDF5</translation>
  </message>
  <message>
   <source>Export its maps as PBR textures, or its BRDF as a table, with the program that it comes from</source>
   <translation>Seine Karten als PBR-Texturen oder seine BRDF als Tabelle aus dem Ursprungsprogramm exportieren</translation>
  </message>
  <message>
   <source>is a bidirectional texture function (BTF)</source>
   <translation>ist eine bidirektionale Texturfunktion (BTF)</translation>
  </message>
  <message>
   <source>Export its maps as PBR textures, or its images as a capture</source>
   <translation>Seine Karten als PBR-Texturen oder seine Bilder als Aufnahme exportieren</translation>
  </message>
  <message>
   <source>, which is not read</source>
   <translation>, das nicht gelesen wird</translation>
  </message>
  <message>
   <source>Name a file, or a model: %1</source>
   <translation>Eine Datei oder ein Modell nennen: %1</translation>
  </message>
  <message>
   <source>%1 is neither a file nor a BRDF model%2; models are %3</source>
   <translation>%1 ist weder eine Datei noch ein BRDF-Modell%2; Modelle sind %3</translation>
  </message>
  <message>
   <source>Download it again from the RGL database</source>
   <translation>Neu aus der RGL-Datenbank herunterladen</translation>
  </message>
  <message>
   <source>covers %1° of azimuth, and 360, 180 or 90 are known</source>
   <translation>umfasst %1° Azimut; bekannt sind 360, 180 oder 90</translation>
  </message>
  <message>
   <source>%1RGL measurement</source>
   <translation>%1RGL-Messung</translation>
  </message>
  <message>
   <source>is a polarised measurement (Mueller matrices over half and difference angles), not an RGL BRDF</source>
   <translation>ist eine polarisierte Messung (Müller-Matrizen über Halb- und Differenzwinkeln), keine RGL-BRDF</translation>
  </message>
  <message>
   <source>Give an unpolarised .bsdf file of the RGL database</source>
   <translation>Eine unpolarisierte .bsdf-Datei der RGL-Datenbank angeben</translation>
  </message>
  <message>
   <source>is a tensor_file without measured reflectance; its fields are %1</source>
   <translation>ist eine tensor_file ohne gemessenen Reflexionsgrad; ihre Felder sind %1</translation>
  </message>
  <message>
   <source>Give a .bsdf file of the RGL database</source>
   <translation>Eine .bsdf-Datei der RGL-Datenbank angeben</translation>
  </message>
  <message>
   <source>lacks the field %1 of an RGL measurement</source>
   <translation>hat kein Feld %1, das Teil einer RGL-Messung ist</translation>
  </message>
  <message>
   <source>has a field %1 of %2 %3: it is damaged</source>
   <translation>hat ein Feld %1 aus %2 %3: es ist beschädigt</translation>
  </message>
  <message>
   <source>has %1 numbers as %2, not one: it is damaged</source>
   <translation>hat %1 Zahlen als %2, nicht eine: es ist beschädigt</translation>
  </message>
  <message>
   <source>has %1 that are not angles in rising order: it is damaged</source>
   <translation>hat %1, die keine steigenden Winkel sind: es ist beschädigt</translation>
  </message>
  <message>
   <source>has %1 that is not a table of positive numbers: it is damaged</source>
   <translation>hat %1, das keine Tabelle positiver Zahlen ist: es ist beschädigt</translation>
  </message>
  <message>
   <source>has %1 that is 0 for some incident direction: it is damaged</source>
   <translation>hat %1, das für eine Einfallsrichtung 0 ist: es ist beschädigt</translation>
  </message>
  <message>
   <source>%1 × %2 incident directions, not %3 × %4</source>
   <translation>%1 × %2 Einfallsrichtungen, nicht %3 × %4</translation>
  </message>
  <message>
   <source>has %1 for %2: it is damaged</source>
   <translation>hat %1 für %2: es ist beschädigt</translation>
  </message>
  <message>
   <source>has %1 in %2 bands, and %3 wavelengths: it is damaged</source>
   <translation>hat %1 in %2 Bändern und %3 Wellenlängen: es ist beschädigt</translation>
  </message>
  <message>
   <source>has wavelengths that cannot be used: %1</source>
   <translation>hat unbrauchbare Wellenlängen: %1</translation>
  </message>
  <message>
   <source>%1 of %2 measured directions have a negative value; negative reflectance is taken as 0</source>
   <translation>%1 von %2 gemessenen Richtungen haben einen negativen Wert; negativer Reflexionsgrad gilt als 0</translation>
  </message>
  <message>
   <source>%1 of %2 measured directions have a value that is not a finite number; it is taken as 0</source>
   <translation>%1 von %2 gemessenen Richtungen haben einen nicht endlichen Wert; er gilt als 0</translation>
  </message>
  <message>
   <source>light was measured from %1° to %2°; beyond, the nearest measurement is taken</source>
   <translation>Licht wurde von %1° bis %2° gemessen; darüber hinaus gilt die nächste Messung</translation>
  </message>
  <message>
   <source>azimuths were measured from %1° to %2°; beyond, the nearest measurement is taken</source>
   <translation>Azimute wurden von %1° bis %2° gemessen; darüber hinaus gilt die nächste Messung</translation>
  </message>
  <message>
   <source>Write the table again with this program</source>
   <translation>Die Tabelle neu mit diesem Programm schreiben</translation>
  </message>
  <message>
   <source>1/sr, without the cosine</source>
   <translation>1/sr, ohne den Kosinus</translation>
  </message>
  <message>
   <source>linear sRGB</source>
   <translation>lineares sRGB</translation>
  </message>
  <message>
   <source>The values are rounded from float64 to float32, 6·10⁻⁸ relative.</source>
   <translation>Die Werte sind von float64 auf float32 gerundet, 6·10⁻⁸ relativ.</translation>
  </message>
  <message>
   <source>has no channel %1 of %2 × %3 floats, as its table needs</source>
   <translation>hat keinen Kanal %1 aus %2 × %3 Gleitkommazahlen, wie seine Tabelle ihn braucht</translation>
  </message>
  <message>
   <source>is damaged: its fingerprint does not fit its content</source>
   <translation>ist beschädigt: sein Fingerabdruck passt nicht zum Inhalt</translation>
  </message>
  <message>
   <source>holds a table that cannot be: %1</source>
   <translation>enthält eine unmögliche Tabelle: %1</translation>
  </message>
  <message>
   <source>is an OpenEXR image without the attribute %1</source>
   <translation>ist ein OpenEXR-Bild ohne das Attribut %1</translation>
  </message>
  <message>
   <source>has a faulty attribute %1: %2 %3</source>
   <translation>hat ein fehlerhaftes Attribut %1: %2 %3</translation>
  </message>
  <message>
   <source>states an impossible table of %1 entries</source>
   <translation>gibt eine unmögliche Tabelle mit %1 Einträgen an</translation>
  </message>
  <message>
   <source>states %1 grids for a table in %2</source>
   <translation>gibt %1 Gitter für eine Tabelle in %2 an</translation>
  </message>
  <message>
   <source>is cut off within its list of fields</source>
   <translation>ist in seiner Liste der Felder abgeschnitten</translation>
  </message>
  <message>
   <source>is not a tensor_file: it begins otherwise</source>
   <translation>ist keine tensor_file: es beginnt anders</translation>
  </message>
  <message>
   <source>is a tensor_file of version %1.%2, and 1.0 is read</source>
   <translation>ist eine tensor_file der Version %1.%2; gelesen wird 1.0</translation>
  </message>
  <message>
   <source>Convert it to 1.0</source>
   <translation>In 1.0 umwandeln</translation>
  </message>
  <message>
   <source>is byte-swapped: its numbers are big-endian</source>
   <translation>hat vertauschte Bytes: seine Zahlen sind Big-Endian</translation>
  </message>
  <message>
   <source>Write it in little-endian order</source>
   <translation>In Little-Endian-Reihenfolge schreiben</translation>
  </message>
  <message>
   <source>announces %1 fields, more than %2: it is damaged</source>
   <translation>kündigt %1 Felder an, mehr als %2: es ist beschädigt</translation>
  </message>
  <message>
   <source>has two fields of one name: it is damaged</source>
   <translation>hat zwei Felder desselben Namens: es ist beschädigt</translation>
  </message>
  <message>
   <source>has a field whose name is %1 bytes long: it is damaged</source>
   <translation>hat ein Feld, dessen Name %1 Bytes lang ist: es ist beschädigt</translation>
  </message>
  <message>
   <source>has a field whose name is not text: it is damaged</source>
   <translation>hat ein Feld, dessen Name kein Text ist: es ist beschädigt</translation>
  </message>
  <message>
   <source>has a field %1 of %2 dimensions: it is damaged</source>
   <translation>hat ein Feld %1 mit %2 Dimensionen: es ist beschädigt</translation>
  </message>
  <message>
   <source>has a field %1 of the unknown type %2: it is damaged</source>
   <translation>hat ein Feld %1 des unbekannten Typs %2: es ist beschädigt</translation>
  </message>
  <message>
   <source>is damaged: its field %1 of %2 numbers does not fit into its %3 bytes</source>
   <translation>ist beschädigt: sein Feld %1 aus %2 Zahlen passt nicht in seine %3 Bytes</translation>
  </message>
  <message>
   <source>is cut off: its field %1 ends at byte %2, the file at %3</source>
   <translation>ist abgeschnitten: sein Feld %1 endet bei Byte %2, die Datei bei %3</translation>
  </message>
  <message>
   <source>the list of fields</source>
   <translation>die Liste der Felder</translation>
  </message>
  <message>
   <source>has a field %1 that lies over %2: it is damaged</source>
   <translation>hat ein Feld %1, das über %2 liegt: es ist beschädigt</translation>
  </message>
  <message>
   <source>Correct the file, or export it again from the program that wrote it</source>
   <translation>Die Datei berichtigen oder aus dem Ursprungsprogramm neu exportieren</translation>
  </message>
  <message>
   <source>has %1 characters; at most %2 are read</source>
   <translation>hat %1 Zeichen; gelesen werden höchstens %2</translation>
  </message>
  <message>
   <source>has a decimal comma in %1</source>
   <translation>hat ein Dezimalkomma in %1</translation>
  </message>
  <message>
   <source>Write decimal points</source>
   <translation>Dezimalpunkte schreiben</translation>
  </message>
  <message>
   <source>has %1 where a number is needed</source>
   <translation>hat %1, wo eine Zahl nötig ist</translation>
  </message>
  <message>
   <source>holds %1 samples; at most %2 are read</source>
   <translation>enthält %1 Abtastungen; gelesen werden höchstens %2</translation>
  </message>
  <message>
   <source>is not text (byte %1 at %2)</source>
   <translation>ist kein Text (Byte %1 bei %2)</translation>
  </message>
  <message>
   <source>is damaged: it begins as %1 text and does not go on so</source>
   <translation>ist beschädigt: es beginnt als %1-Text und geht nicht so weiter</translation>
  </message>
  <message>
   <source>Convert it to little-endian float64</source>
   <translation>In float64 in Little-Endian umwandeln</translation>
  </message>
  <message>
   <source>holds only negative entries, so that nothing was measured</source>
   <translation>enthält nur negative Einträge, sodass nichts gemessen wurde</translation>
  </message>
  <message>
   <source>UTIA table</source>
   <translation>UTIA-Tabelle</translation>
  </message>
  <message>
   <source>has %1 bytes where a UTIA table has %2</source>
   <translation>hat %1 Bytes, wo eine UTIA-Tabelle %2 hat</translation>
  </message>
  <message>
   <source>Give a binary UTIA file of 288 × 288 directions as published</source>
   <translation>Eine binäre UTIA-Datei mit 288 × 288 Richtungen angeben, wie sie veröffentlicht ist</translation>
  </message>
  <message>
   <source>sampling the reflectance</source>
   <translation>Reflexion wird abgetastet</translation>
  </message>
  <message>
   <source>resampled table</source>
   <translation>neu abgetastete Tabelle</translation>
  </message>
  <message>
   <source>Resampling to a table has an error of %1 RMS.</source>
   <translation>Die Umrechnung in eine Tabelle hat einen Fehler von %1 RMS.</translation>
  </message>
  <message>
   <source>The BRDF is anisotropic; the table is its mean over the azimuths of the half vector.</source>
   <translation>Die BRDF ist anisotrop; die Tabelle ist ihr Mittel über die Azimute des Halbvektors.</translation>
  </message>
  <message>
   <source>The BRDF is not reciprocal; the table is the mean of both directions of the light.</source>
   <translation>Die BRDF ist nicht reziprok; die Tabelle ist das Mittel beider Lichtrichtungen.</translation>
  </message>
  <message>
   <source>dropped: at or below the horizon</source>
   <translation>verworfen: am oder unter dem Horizont</translation>
  </message>
  <message>
   <source>has no valid measurement among its %1</source>
   <translation>hat keine gültige Messung unter %1</translation>
  </message>
  <message>
   <source>cannot be turned into a colour: %1</source>
   <translation>lässt sich nicht in eine Farbe umrechnen: %1</translation>
  </message>
  <message>
   <source>dropped: not finite</source>
   <translation>verworfen: nicht endlich</translation>
  </message>
  <message>
   <source>dropped: negative</source>
   <translation>verworfen: negativ</translation>
  </message>
  <message>
   <source>outside sRGB</source>
   <translation>außerhalb von sRGB</translation>
  </message>
  <message>
   <source>negative channels</source>
   <translation>negative Kanäle</translation>
  </message>
  <message>
   <source>%1 of %2 measurements have a negative channel, which is taken as 0</source>
   <translation>%1 von %2 Messungen haben einen negativen Kanal, der als 0 gilt</translation>
  </message>
  <message>
   <source>%1 of %2 measurements are not used (%3)</source>
   <translation>%1 von %2 Messungen werden nicht verwendet (%3)</translation>
  </message>
  <message>
   <source>absurdly large</source>
   <translation>unsinnig groß</translation>
  </message>
  <message>
   <source>interpolation, box %1 of %2</source>
   <translation>Interpolation, Bereich %1 von %2</translation>
  </message>
  <message>
   <source>condition number</source>
   <translation>Konditionszahl</translation>
  </message>
  <message>
   <source>leave-one-out, relative</source>
   <translation>Auslassfehler, relativ</translation>
  </message>
  <message>
   <source>leave-one-out, logarithmic</source>
   <translation>Auslassfehler, logarithmisch</translation>
  </message>
  <message>
   <source>samples merged</source>
   <translation>zusammengefasste Abtastungen</translation>
  </message>
  <message>
   <source>the interpolation is ill-conditioned (%1); smoothing helps</source>
   <translation>die Interpolation ist schlecht konditioniert (%1); Glättung hilft</translation>
  </message>
  <message>
   <source>%1 samples repeat the directions of another, or are its image by symmetry; their mean is kept</source>
   <translation>%1 Abtastungen wiederholen die Richtungen einer anderen oder sind ihr Bild durch Symmetrie; ihr Mittel bleibt</translation>
  </message>
  <message>
   <source>choice of coordinates and kernel</source>
   <translation>Wahl von Koordinaten und Kern</translation>
  </message>
  <message>
   <source>wavelengths must be a list of finite numbers in rising order</source>
   <translation>Wellenlängen müssen eine Liste endlicher Zahlen in steigender Reihenfolge sein</translation>
  </message>
  <message>
   <source>no wavelength lies between %1 and %2 nm</source>
   <translation>keine Wellenlänge liegt zwischen %1 und %2 nm</translation>
  </message>
  <message>
   <source>filled along phi from the nearest measured values, empty rows from the nearest row</source>
   <translation>längs phi aus den nächsten gemessenen Werten gefüllt, leere Zeilen aus der nächsten Zeile</translation>
  </message>
  <message>
   <source>%1 of %2 entries are missing; they are %3.</source>
   <translation>%1 von %2 Einträgen fehlen; sie sind %3.</translation>
  </message>
  <message>
   <source>line %1: %2</source>
   <translation>Zeile %1: %2</translation>
  </message>
  <message>
   <source>written in GLSL</source>
   <translation>in GLSL geschrieben</translation>
  </message>
  <message>
   <source>has %1 bytes of text, more than %2</source>
   <translation>hat %1 Bytes Text, mehr als %2</translation>
  </message>
  <message>
   <source>Shorten it</source>
   <translation>Kürzen</translation>
  </message>
  <message>
   <source>are infinite or no numbers</source>
   <translation>sind unendlich oder keine Zahlen</translation>
  </message>
  <message>
   <source>are negative</source>
   <translation>sind negativ</translation>
  </message>
  <message>
   <source>%1 of the values %2 and count as 0.</source>
   <translation>%1 der Werte %2 und zählen als 0.</translation>
  </message>
  <message>
   <source>takes more than %1 s to evaluate</source>
   <translation>braucht zur Auswertung mehr als %1 s</translation>
  </message>
  <message>
   <source>Shorten its loops</source>
   <translation>Die Schleifen kürzen</translation>
  </message>
  <message>
   <source>hangs: not evaluated within %1 s</source>
   <translation>hängt: in %1 s nicht ausgewertet</translation>
  </message>
  <message>
   <source>makes the driver of OpenGL crash</source>
   <translation>bringt den OpenGL-Treiber zum Absturz</translation>
  </message>
  <message>
   <source>Write it more simply</source>
   <translation>Einfacher schreiben</translation>
  </message>
  <message>
   <source>Correct it there</source>
   <translation>Dort korrigieren</translation>
  </message>
  <message>
   <source>the function BRDF does not fit the rest (%1)</source>
   <translation>die Funktion BRDF passt nicht zum Rest (%1)</translation>
  </message>
  <message>
   <source>Close all brackets, comments and #if</source>
   <translation>Alle Klammern, Kommentare und #if schließen</translation>
  </message>
  <message>
   <source>does not compile (%1)</source>
   <translation>lässt sich nicht übersetzen (%1)</translation>
  </message>
  <message>
   <source>Correct the shader</source>
   <translation>Den Shader korrigieren</translation>
  </message>
  <message>
   <source>has more than %1 bytes of text</source>
   <translation>hat mehr als %1 Bytes Text</translation>
  </message>
  <message>
   <source>holds a zero byte</source>
   <translation>enthält ein Nullbyte</translation>
  </message>
  <message>
   <source>does not begin with the word analytic</source>
   <translation>beginnt nicht mit dem Wort analytic</translation>
  </message>
  <message>
   <source>Write it into the first line</source>
   <translation>In die erste Zeile schreiben</translation>
  </message>
  <message>
   <source>%1 has not ended</source>
   <translation>%1 ist nicht beendet</translation>
  </message>
  <message>
   <source>Write ::end %1 before it</source>
   <translation>Davor ::end %1 schreiben</translation>
  </message>
  <message>
   <source>ends %1, not %2</source>
   <translation>beendet %1, nicht %2</translation>
  </message>
  <message>
   <source>Pair them</source>
   <translation>Paarweise schreiben</translation>
  </message>
  <message>
   <source>%1 never ends</source>
   <translation>%1 endet nie</translation>
  </message>
  <message>
   <source>Write ::end %1 after it</source>
   <translation>Danach ::end %1 schreiben</translation>
  </message>
  <message>
   <source>Write vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) between ::begin shader and ::end shader</source>
   <translation>vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) zwischen ::begin shader und ::end shader schreiben</translation>
  </message>
  <message>
   <source>has no function BRDF</source>
   <translation>hat keine Funktion BRDF</translation>
  </message>
  <message>
   <source>#%1 is not allowed</source>
   <translation>#%1 ist nicht erlaubt</translation>
  </message>
  <message>
   <source>Remove the line: a text stands for itself</source>
   <translation>Die Zeile entfernen: ein Text steht für sich</translation>
  </message>
  <message>
   <source>declares more than %1 parameters</source>
   <translation>deklariert mehr als %1 Parameter</translation>
  </message>
  <message>
   <source>Leave some out</source>
   <translation>Einige weglassen</translation>
  </message>
  <message>
   <source>declares %1 again</source>
   <translation>deklariert %1 noch einmal</translation>
  </message>
  <message>
   <source>Give it another name</source>
   <translation>Einen anderen Namen geben</translation>
  </message>
  <message>
   <source>%1 is not a kind of parameter</source>
   <translation>%1 ist keine Art von Parameter</translation>
  </message>
  <message>
   <source>Write float, bool or color</source>
   <translation>float, bool oder color schreiben</translation>
  </message>
  <message>
   <source>is not a parameter</source>
   <translation>ist kein Parameter</translation>
  </message>
  <message>
   <source>%1 is not a name for a parameter</source>
   <translation>%1 ist kein Name für einen Parameter</translation>
  </message>
  <message>
   <source>Use letters, digits and _</source>
   <translation>Buchstaben, Ziffern und _ verwenden</translation>
  </message>
  <message>
   <source>the range of %1 is empty</source>
   <translation>der Bereich von %1 ist leer</translation>
  </message>
  <message>
   <source>Write a highest above the lowest</source>
   <translation>Einen Höchstwert über dem kleinsten schreiben</translation>
  </message>
 </context>
 <context>
  <name>engine/factor</name>
  <message>
   <source>For direct light take half and difference vectors (parametrisation half-diff): as many terms of them are off by %1, where these are by %2.</source>
   <translation>Für direktes Licht Halb- und Differenzvektoren nehmen (Parametrisierung half-diff): ebenso viele Terme davon weichen um %1 ab, diese um %2.</translation>
  </message>
  <message>
   <source>sampling the BRDF</source>
   <translation>BRDF wird abgetastet</translation>
  </message>
  <message>
   <source>the BRDF is not a finite number for light at %1° and viewer at %2°</source>
   <translation>die BRDF ist keine endliche Zahl für Licht bei %1° und Blick bei %2°</translation>
  </message>
  <message>
   <source>no further term lowers the held-out errors</source>
   <translation>kein weiterer Term senkt die zurückgehaltenen Fehler</translation>
  </message>
  <message>
   <source>from %1 to %2</source>
   <translation>von %1 auf %2</translation>
  </message>
  <message>
   <source>one more raises the held-out RMS × cos %1 sr⁻¹</source>
   <translation>einer mehr erhöht den zurückgehaltenen RMS × cos %1 sr⁻¹</translation>
  </message>
  <message>
   <source>one more raises the held-out squared logarithm %1</source>
   <translation>einer mehr erhöht den zurückgehaltenen quadratischen Logarithmus %1</translation>
  </message>
  <message>
   <source>further ones raise the held-out errors, although one more lowers the RMS × cos %1 sr⁻¹</source>
   <translation>weitere erhöhen die zurückgehaltenen Fehler, obwohl einer mehr den RMS × cos %1 sr⁻¹ senkt</translation>
  </message>
  <message>
   <source>for image-based light take the Gaussian mode, which follows the highlight itself</source>
   <translation>für bildbasiertes Licht den Gauß-Modus nehmen, der dem Glanzlicht selbst folgt</translation>
  </message>
  <message>
   <source>At %1 of all pairs of directions the factors are cut at three times the largest value measured within 12°.</source>
   <translation>Bei %1 aller Richtungspaare sind die Faktoren beim Dreifachen des größten innerhalb von 12° gemessenen Werts gekappt.</translation>
  </message>
  <message>
   <source>Use these factors for nothing: they are off by %1 of the reflectance (RMS). Draw the reflectance itself, or a model fitted to it; %2.</source>
   <translation>Diese Faktoren für nichts verwenden: sie weichen um %1 des Reflexionsgrads ab (RMS). Das Reflexionsverhalten selbst zeichnen oder ein daran angepasstes Modell; %2.</translation>
  </message>
  <message>
   <source>The highlight is too narrow for these factors, which are off by %1 of the reflectance (RMS): %2.</source>
   <translation>Das Glanzlicht ist zu schmal für diese Faktoren, die um %1 des Reflexionsgrads abweichen (RMS): %2.</translation>
  </message>
  <message>
   <source>this term</source>
   <translation>diesen Term</translation>
  </message>
  <message>
   <source>these %1 terms</source>
   <translation>diese %1 Terme</translation>
  </message>
  <message>
   <source>Precomputed transport in wavelets can use %1: light maps go into the transport, view maps are sampled while drawing.</source>
   <translation>Vorberechneter Transport in Wavelets kann %1 verwenden: Lichtkarten gehen in den Transport ein, Blickkarten werden beim Zeichnen abgetastet.</translation>
  </message>
  <message>
   <source>Direct light can use them too: two samples a term for each light.</source>
   <translation>Auch direktes Licht kann sie verwenden: zwei Abtastungen je Term und Licht.</translation>
  </message>
  <message>
   <source>Direct light in the viewport can use %1: textures of the half and the difference vector.</source>
   <translation>Direktes Licht in der Ansicht kann %1 verwenden: Texturen des Halb- und des Differenzvektors.</translation>
  </message>
  <message>
   <source>Precomputed transport in wavelets cannot: it needs factors of the incident and the outgoing direction.</source>
   <translation>Vorberechneter Transport in Wavelets kann es nicht: er braucht Faktoren der Einfalls- und der Ausfallsrichtung.</translation>
  </message>
  <message>
   <source>two samples a texture</source>
   <translation>zwei Abtastungen je Textur</translation>
  </message>
  <message>
   <source>one sample a texture</source>
   <translation>eine Abtastung je Textur</translation>
  </message>
  <message>
   <source>this texture</source>
   <translation>diese Textur</translation>
  </message>
  <message>
   <source>these %1 textures</source>
   <translation>diese %1 Texturen</translation>
  </message>
  <message>
   <source>Direct light in the viewport can use %1: %2 for each light.</source>
   <translation>Direktes Licht in der Ansicht kann %1 verwenden: %2 für jedes Licht.</translation>
  </message>
  <message>
   <source>Precomputed transport in wavelets cannot: it needs a sum of products, and this is one product.</source>
   <translation>Vorberechneter Transport in Wavelets kann es nicht: er braucht eine Summe von Produkten, und dies ist ein einziges Produkt.</translation>
  </message>
  <message>
   <source>%1 was taken by its held-out errors: RMS %2 and squared logarithm %3, where %4 had %5 and %6.</source>
   <translation>%1 wurde nach seinen zurückgehaltenen Fehlern gewählt: RMS %2 und quadratischer Logarithmus %3; %4 hatte %5 und %6.</translation>
  </message>
  <message>
   <source>a search cannot go on from factors of the method %1</source>
   <translation>eine Suche kann nicht von Faktoren des Verfahrens %1 ausgehen</translation>
  </message>
  <message>
   <source>these factors are of %1, and cannot go on as factors of %2</source>
   <translation>diese Faktoren gehören zu %1 und lassen sich nicht als Faktoren von %2 fortsetzen</translation>
  </message>
  <message>
   <source>between texels</source>
   <translation>zwischen Texeln</translation>
  </message>
  <message>
   <source>comparing %1 terms</source>
   <translation>%1 Terme werden verglichen</translation>
  </message>
  <message>
   <source>comparing norms</source>
   <translation>Normen werden verglichen</translation>
  </message>
  <message>
   <source>Factor the BRDF again with lightarc factor</source>
   <translation>Die BRDF mit lightarc factor neu faktorisieren</translation>
  </message>
  <message>
   <source>%1 does not describe factors</source>
   <translation>%1 beschreibt keine Faktoren</translation>
  </message>
  <message>
   <source>was written by a newer Lightarc (version %1)</source>
   <translation>wurde von einem neueren Lightarc geschrieben (Version %1)</translation>
  </message>
  <message>
   <source>%1 has a faulty %2 (%3)</source>
   <translation>%1 hat ein fehlerhaftes %2 (%3)</translation>
  </message>
  <message>
   <source>holds factors that cannot be: %1</source>
   <translation>enthält ungültige Faktoren: %1</translation>
  </message>
  <message>
   <source>is not an image of %1 × %2 texels of 32-bit floats</source>
   <translation>ist kein Bild von %1 × %2 Texeln aus 32-Bit-Gleitkommazahlen</translation>
  </message>
  <message>
   <source>holding out regions</source>
   <translation>Bereiche werden zurückgehalten</translation>
  </message>
  <message>
   <source>solving for all textures</source>
   <translation>alle Texturen werden gelöst</translation>
  </message>
  <message>
   <source>a BRDF that is 0 everywhere has no logarithm</source>
   <translation>eine BRDF, die überall 0 ist, hat keinen Logarithmus</translation>
  </message>
  <message>
   <source>homomorphic factors</source>
   <translation>homomorphe Faktoren</translation>
  </message>
  <message>
   <source>averaging rows of norm %1</source>
   <translation>Zeilen der Norm %1 werden gemittelt</translation>
  </message>
  <message>
   <source>a search goes on with the parametrisation and reciprocity that it started with</source>
   <translation>eine Suche wird mit der Parametrisierung und Reziprozität fortgesetzt, mit der sie begann</translation>
  </message>
  <message>
   <source>a search goes on with the size and epsilon that it started with, %1 and %2</source>
   <translation>eine Suche wird mit der Größe und dem Epsilon fortgesetzt, mit denen sie begann, %1 und %2</translation>
  </message>
  <message>
   <source>term %1 of %2</source>
   <translation>Term %1 von %2</translation>
  </message>
  <message>
   <source>term %1 of %2, %3 tried</source>
   <translation>Term %1 von %2, %3 versucht</translation>
  </message>
  <message>
   <source>at least one term is needed, not %1</source>
   <translation>mindestens ein Term ist nötig, nicht %1</translation>
  </message>
  <message>
   <source>over half and difference vectors no matrix is symmetric; take the method svd or power</source>
   <translation>über Halb- und Differenzvektoren ist keine Matrix symmetrisch; das Verfahren Singulärwerte oder Potenzmethode wählen</translation>
  </message>
  <message>
   <source>the matrix of this BRDF is not symmetric (asymmetry %1); take the method svd or power</source>
   <translation>die Matrix dieser BRDF ist nicht symmetrisch (Asymmetrie %1); das Verfahren Singulärwerte oder Potenzmethode wählen</translation>
  </message>
  <message>
   <source>finding terms in the %1 norm</source>
   <translation>Terme in der %1-Norm werden gesucht</translation>
  </message>
  <message>
   <source>separable factors</source>
   <translation>separable Faktoren</translation>
  </message>
  <message>
   <source>the sum of %1 terms is below 0 in places, which are drawn black: that adds %2 to the energy; no sum of the method nonnegative is</source>
   <translation>die Summe von %1 Termen liegt stellenweise unter 0, was schwarz gezeichnet wird: das fügt der Energie %2 hinzu; keine Summe des nichtnegativen Verfahrens tut das</translation>
  </message>
  <message>
   <source>Symmetric</source>
   <translation>Symmetrisch</translation>
  </message>
  <message>
   <source>Singular values</source>
   <translation>Singulärwerte</translation>
  </message>
  <message>
   <source>Power iteration</source>
   <translation>Potenzmethode</translation>
  </message>
  <message>
   <source>Non-negative</source>
   <translation>Nichtnegativ</translation>
  </message>
  <message>
   <source>One positive term</source>
   <translation>Ein positiver Term</translation>
  </message>
  <message>
   <source>Fixed (McCool)</source>
   <translation>Fest (McCool)</translation>
  </message>
  <message>
   <source>Search (Cole)</source>
   <translation>Suche (Cole)</translation>
  </message>
  <message>
   <source>auto: of a formula, symmetric if its matrix is symmetric, otherwise svd; of a measurement these or a search, whichever is better in held-out regions of directions; nonnegative: no pair of directions is negative, and dark values are nearer, for some more squared error</source>
   <translation>auto: bei einer Formel symmetrisch, wenn ihre Matrix symmetrisch ist, sonst svd; bei einer Messung diese oder eine Suche, je nachdem, was in zurückgehaltenen Richtungsbereichen besser ist; nonnegative: kein Richtungspaar ist negativ, und dunkle Werte sind näher, bei etwas größerem quadratischem Fehler</translation>
  </message>
  <message>
   <source>Light and view</source>
   <translation>Licht und Blick</translation>
  </message>
  <message>
   <source>Half and difference</source>
   <translation>Halb und Differenz</translation>
  </message>
  <message>
   <source>The better one</source>
   <translation>Die bessere</translation>
  </message>
  <message>
   <source>light and viewer, or half and difference vector (Kautz and McCool's, for direct light); auto: the better one (separable methods)</source>
   <translation>Licht und Blick oder Halb- und Differenzvektor (der von Kautz und McCool, für direktes Licht); auto: die bessere (separable Verfahren)</translation>
  </message>
  <message>
   <source>By directions</source>
   <translation>Nach Richtungen</translation>
  </message>
  <message>
   <source>Orthographic</source>
   <translation>Orthographisch</translation>
  </message>
  <message>
   <source>Polar</source>
   <translation>Polar</translation>
  </message>
  <message>
   <source>Parabolic</source>
   <translation>Parabolisch</translation>
  </message>
  <message>
   <source>The best one</source>
   <translation>Die beste</translation>
  </message>
  <message>
   <source>hemisphere map of separable textures (orthographic; half-diff: polar, highlight at the pole); auto: best</source>
   <translation>Abbildung der Halbkugel für separable Texturen (orthographisch; half-diff: polar, Glanzlicht am Pol); auto: die beste</translation>
  </message>
  <message>
   <source>norm of the separable methods; auto: the one with the lower cosine-weighted error</source>
   <translation>Norm der separablen Verfahren; auto: die mit dem kleineren kosinusgewichteten Fehler</translation>
  </message>
  <message>
   <source>texels along a side of each map</source>
   <translation>Texel je Kante jeder Karte</translation>
  </message>
  <message>
   <source>most products of two maps</source>
   <translation>Höchstzahl der Produkte zweier Karten</translation>
  </message>
  <message>
   <source>most texels along a side of a texture</source>
   <translation>Höchstzahl der Texel je Kante einer Textur</translation>
  </message>
  <message>
   <source>most textures</source>
   <translation>Höchstzahl der Texturen</translation>
  </message>
  <message>
   <source>enforce reciprocity exactly (homomorphic and search)</source>
   <translation>Reziprozität exakt erzwingen (homomorph und Suche)</translation>
  </message>
  <message>
   <source>random starts of the search for each texture</source>
   <translation>zufällige Starts der Suche je Textur</translation>
  </message>
  <message>
   <source>textures solved for each projection tried</source>
   <translation>gelöste Texturen je versuchter Projektion</translation>
  </message>
  <message>
   <source>pairs of directions at which models are sampled</source>
   <translation>Richtungspaare, an denen Modelle abgetastet werden</translation>
  </message>
  <message>
   <source>largest angle of these pairs from the normal, for models only</source>
   <translation>größter Winkel dieser Paare zur Normalen, nur für Modelle</translation>
  </message>
  <message>
   <source>added before the logarithm, relative to the mean</source>
   <translation>vor dem Logarithmus addiert, im Verhältnis zum Mittel</translation>
  </message>
  <message>
   <source>error by which the search chooses projections: logarithms count dark and bright alike, and the cosine-weighted RMS, which bright values dominate, can rise with them; sq weighs bright values most</source>
   <translation>Fehler, nach dem die Suche Projektionen wählt: Logarithmen zählen dunkel und hell gleich; der kosinusgewichtete RMS, den helle Werte bestimmen, kann dabei steigen; sq gewichtet helle Werte am stärksten</translation>
  </message>
  <message>
   <source>Ours</source>
   <translation>Eigene</translation>
  </message>
  <message>
   <source>As in the thesis</source>
   <translation>Wie in der Dissertation</translation>
  </message>
  <message>
   <source>default: terms, smoothness and size that are best on held-out regions; thesis: Cole's search</source>
   <translation>default: Terme, Glättung und Größe, die in zurückgehaltenen Bereichen am besten sind; thesis: Coles Suche</translation>
  </message>
  <message>
   <source>seed of samples and starts: equal seeds give equal factors</source>
   <translation>Startwert der Abtastungen und Starts: gleiche Startwerte ergeben gleiche Faktoren</translation>
  </message>
  <message>
   <source>Over half and difference vectors no matrix is symmetric: take singular values, or light and view</source>
   <translation>Über Halb- und Differenzvektoren ist keine Matrix symmetrisch: Singulärwerte oder Licht und Blick nehmen</translation>
  </message>
  <message>
   <source>Choose one of the two parametrisations: this method does not try both</source>
   <translation>Eine der beiden Parametrisierungen wählen: dieses Verfahren versucht nicht beide</translation>
  </message>
  <message>
   <source>%1 texels have no sample; smoothing above 0 fills them</source>
   <translation>%1 Texel haben keine Abtastung; eine Glättung über 0 füllt sie</translation>
  </message>
  <message>
   <source>, most of those with light or viewer beyond %1°</source>
   <translation>, die meisten davon mit Licht oder Blick jenseits von %1°</translation>
  </message>
  <message>
   <source>Nothing was measured within %1° of %2 of all pairs of directions%3: there the factors are a guess, and no error is known.</source>
   <translation>Bei %2 aller Richtungspaare%3 wurde innerhalb von %1° nichts gemessen: dort sind die Faktoren geraten, und kein Fehler ist bekannt.</translation>
  </message>
  <message>
   <source>choosing the smoothness</source>
   <translation>Glättung wird gewählt</translation>
  </message>
  <message>
   <source>%1 must lie in [%2, %3], not %4</source>
   <translation>%1 muss in [%2, %3] liegen, nicht %4</translation>
  </message>
  <message>
   <source>the lower size must be 0 or lie in [%1, %2], not %3</source>
   <translation>die untere Größe muss 0 sein oder in [%1, %2] liegen, nicht %3</translation>
  </message>
  <message>
   <source>the smoothing must not be negative, but is %1</source>
   <translation>die Glättung darf nicht negativ sein, ist aber %1</translation>
  </message>
  <message>
   <source>the share that is held out must lie in [0, 1), not %1</source>
   <translation>der zurückgehaltene Anteil muss in [0, 1) liegen, nicht %1</translation>
  </message>
  <message>
   <source>without restarts, guesses and fixed projections there is nothing to try</source>
   <translation>ohne Neustarts, Startwerte und feste Projektionen gibt es nichts zu versuchen</translation>
  </message>
  <message>
   <source>%1: fixed projections</source>
   <translation>%1: feste Projektionen</translation>
  </message>
  <message>
   <source>%1: done</source>
   <translation>%1: fertig</translation>
  </message>
 </context>
 <context>
  <name>engine/shading</name>
  <message>
   <source>comparing representations</source>
   <translation>Darstellungen werden verglichen</translation>
  </message>
  <message>
   <source>Compiling (first use only)</source>
   <translation>Wird kompiliert (nur beim ersten Mal)</translation>
  </message>
  <message>
   <source>comparing photographs</source>
   <translation>Fotos werden verglichen</translation>
  </message>
  <message>
   <source>leaving photographs out</source>
   <translation>Fotos werden zurückgehalten</translation>
  </message>
  <message>
   <source>writing planes</source>
   <translation>Ebenen werden geschrieben</translation>
  </message>
  <message>
   <source>brightness alone</source>
   <translation>nur Helligkeit</translation>
  </message>
  <message>
   <source>held-out photographs: error %1 8-bit levels, of their mean image %2</source>
   <translation>zurückgehaltene Fotos: Fehler %1 8-Bit-Stufen, ihres mittleren Bildes %2</translation>
  </message>
  <message>
   <source>%1: %2 does not distinguish these photographs</source>
   <translation>%1: %2 unterscheidet diese Fotos nicht</translation>
  </message>
  <message>
   <source>comparing with the photographs</source>
   <translation>Fotos werden verglichen</translation>
  </message>
  <message>
   <source>%1 of the tiles keep their slices; a power law describes this material badly</source>
   <translation>%1 der Kacheln behalten ihre Schichten; ein Potenzgesetz beschreibt dieses Material schlecht</translation>
  </message>
  <message>
   <source>preparing the fit</source>
   <translation>Anpassung wird vorbereitet</translation>
  </message>
  <message>
   <source>fitting the power law</source>
   <translation>Potenzgesetz wird angepasst</translation>
  </message>
  <message>
   <source>%1 of texels and channels</source>
   <translation>%1 der Texel und Kanäle</translation>
  </message>
  <message>
   <source>%1 do not brighten with the light; the error map shows them</source>
   <translation>%1 werden mit dem Licht nicht heller; die Fehlerkarte zeigt sie</translation>
  </message>
  <message>
   <source>%1 are black in every slice</source>
   <translation>%1 sind in jeder Schicht schwarz</translation>
  </message>
  <message>
   <source>the direction of the light</source>
   <translation>die Richtung des Lichts</translation>
  </message>
  <message>
   <source>the shading map</source>
   <translation>die Schattierungskarte</translation>
  </message>
  <message>
   <source>a directional map</source>
   <translation>eine Richtungskarte</translation>
  </message>
  <message>
   <source>%1 has a held-out error of %2 8-bit levels</source>
   <translation>%1 hat einen zurückgehaltenen Fehler von %2 8-Bit-Stufen</translation>
  </message>
  <message>
   <source>their mean image %1</source>
   <translation>ihr mittleres Bild %1</translation>
  </message>
  <message>
   <source>, because the lights come from several azimuths</source>
   <translation>, weil die Lichter aus mehreren Azimuten kommen</translation>
  </message>
  <message>
   <source>Let it choose the representation, import one arc of it (import --arc)</source>
   <translation>Die Darstellung wählen lassen, oder einen Bogen davon importieren (import --arc)</translation>
  </message>
  <message>
   <source>, because their lights do not explain them</source>
   <translation>, weil ihre Lichter sie nicht erklären</translation>
  </message>
  <message>
   <source>Check the light list and the alignment</source>
   <translation>Lichterliste und Ausrichtung prüfen</translation>
  </message>
  <message>
   <source>%1, leave out the others with --exclude, or write it all the same with --force</source>
   <translation>%1, die anderen mit --exclude auslassen oder trotzdem mit --force schreiben</translation>
  </message>
  <message>
   <source>its lamps have no azimuth</source>
   <translation>seine Lampen haben keinen Azimut</translation>
  </message>
  <message>
   <source>Import it with a light list (.lp) or a capture.toml</source>
   <translation>Mit einer Lichtliste (.lp) oder einer capture.toml importieren</translation>
  </message>
  <message>
   <source>%1 photographs are too few to leave one out</source>
   <translation>%1 Fotos sind zu wenige, um eines zurückzuhalten</translation>
  </message>
  <message>
   <source>Use %1 or more</source>
   <translation>Mindestens %1 verwenden</translation>
  </message>
  <message>
   <source>is predicted from the others %1 times worse than is usual for a lamp there: it may have moved, or have another lamp or exposure than is stated. Look at it, and leave it out if that is so</source>
   <translation>wird aus den anderen %1-mal schlechter vorhergesagt, als für eine Lampe dort üblich ist: es kann sich bewegt haben oder eine andere Lampe oder Belichtung haben als angegeben. Ansehen und gegebenenfalls ausschließen</translation>
  </message>
  <message>
   <source>a shading map needs at least 2 slices, not %1</source>
   <translation>eine Schattierungskarte braucht mindestens 2 Schichten, nicht %1</translation>
  </message>
  <message>
   <source>preparing to linearise</source>
   <translation>Linearisierung wird vorbereitet</translation>
  </message>
  <message>
   <source>its mean radiance is not finite</source>
   <translation>seine mittlere Strahldichte ist nicht endlich</translation>
  </message>
  <message>
   <source>no light: every photograph is black</source>
   <translation>kein Licht: jedes Foto ist schwarz</translation>
  </message>
  <message>
   <source>Check the exposure and the dark frame</source>
   <translation>Belichtung und Dunkelbild prüfen</translation>
  </message>
  <message>
   <source>its mean radiances do not belong to its pixels</source>
   <translation>seine mittleren Strahldichten gehören nicht zu seinen Pixeln</translation>
  </message>
  <message>
   <source>the stack holds no photograph called %1</source>
   <translation>der Stapel enthält kein Foto namens %1</translation>
  </message>
  <message>
   <source>every photograph is excluded</source>
   <translation>jedes Foto ist ausgeschlossen</translation>
  </message>
  <message>
   <source>Include some of them</source>
   <translation>Einige davon einschließen</translation>
  </message>
  <message>
   <source>darker on average (%1) than the photograph at the light's elevation before it (%2); sorted by mean radiance</source>
   <translation>im Mittel dunkler (%1) als das Foto bei der Lichtelevation davor (%2); nach mittlerer Strahldichte sortiert</translation>
  </message>
  <message>
   <source>black on average; not used</source>
   <translation>im Mittel schwarz; nicht verwendet</translation>
  </message>
  <message>
   <source>excluded; not used</source>
   <translation>ausgeschlossen; nicht verwendet</translation>
  </message>
  <message>
   <source>one photograph: every slice is a darker copy of it</source>
   <translation>ein Foto: jede Schicht ist eine dunklere Kopie davon</translation>
  </message>
  <message>
   <source>photographs of equal mean radiance were averaged</source>
   <translation>Fotos gleicher mittlerer Strahldichte wurden gemittelt</translation>
  </message>
  <message>
   <source>slice 0 is black by definition; the darkest photograph has a mean radiance of %1</source>
   <translation>Schicht 0 ist definitionsgemäß schwarz; das dunkelste Foto hat eine mittlere Strahldichte von %1</translation>
  </message>
  <message>
   <source>%1, %2 slices between them are darkened copies of it</source>
   <translation>%1, %2 Schichten dazwischen sind abgedunkelte Kopien davon</translation>
  </message>
  <message>
   <source>has no arc of lamps: nowhere are there three elevations within 10° of one azimuth</source>
   <translation>hat keinen Bogen von Lampen: nirgends gibt es drei Elevationen innerhalb von 10° eines Azimuts</translation>
  </message>
  <message>
   <source>Use all lamps, or import more photographs</source>
   <translation>Alle Lampen verwenden oder mehr Fotos importieren</translation>
  </message>
  <message>
   <source>has fewer than two lamps at the azimuth %1° ± %2°</source>
   <translation>hat weniger als zwei Lampen beim Azimut %1° ± %2°</translation>
  </message>
  <message>
   <source>Widen the tolerance, or choose another azimuth</source>
   <translation>Die Toleranz erhöhen oder einen anderen Azimut wählen</translation>
  </message>
  <message>
   <source>finding where the material repeats</source>
   <translation>Wiederholung des Materials wird gesucht</translation>
  </message>
  <message>
   <source>a sample of %1 x %2 texels is too small to be made tileable</source>
   <translation>eine Probe von %1 x %2 Texeln ist zu klein, um kachelbar zu werden</translation>
  </message>
  <message>
   <source>an overlap of %1 texels does not fit a sample of %2 x %3</source>
   <translation>eine Überlappung von %1 Texeln passt nicht zu einer Probe von %2 x %3</translation>
  </message>
  <message>
   <source>Choose a smaller overlap or a larger crop</source>
   <translation>Eine kleinere Überlappung oder einen größeren Ausschnitt wählen</translation>
  </message>
  <message>
   <source>the material</source>
   <translation>das Material</translation>
  </message>
  <message>
   <source>lighting the planes</source>
   <translation>Ebenen werden beleuchtet</translation>
  </message>
  <message>
   <source>tileable: %1 x %2 texels of the sample's %3 x %4</source>
   <translation>kachelbar: %1 x %2 der %3 x %4 Texel der Probe</translation>
  </message>
  <message>
   <source>steps across the seams are %1 times those of the sample; they can be seen</source>
   <translation>Stufen an den Nähten sind %1-mal die der Probe; sie sind sichtbar</translation>
  </message>
  <message>
   <source>copying the tile</source>
   <translation>Kachel wird kopiert</translation>
  </message>
 </context>
 <context>
  <name>engine/surface</name>
  <message>
   <source>looking for depth edges</source>
   <translation>Tiefensprünge werden gesucht</translation>
  </message>
  <message>
   <source>solving for the height</source>
   <translation>Höhe wird berechnet</translation>
  </message>
  <message>
   <source>Finding what hides the sky</source>
   <translation>Himmelsanteil wird bestimmt</translation>
  </message>
  <message>
   <source>does not know the azimuth of its lamps, so it is not known in which direction slopes lie</source>
   <translation>kennt den Azimut seiner Lampen nicht, also ist unbekannt, in welcher Richtung Steigungen liegen</translation>
  </message>
  <message>
   <source>Import it with a light list (.lp), with azimuth_deg in a capture.toml, or with --estimate-lights</source>
   <translation>Mit einer Lichtliste (.lp), mit azimuth_deg in einer capture.toml oder mit geschätzten Lichtern importieren</translation>
  </message>
  <message>
   <source>1 direction</source>
   <translation>1 Richtung</translation>
  </message>
  <message>
   <source>%1 directions</source>
   <translation>%1 Richtungen</translation>
  </message>
  <message>
   <source>is lit from %1, which do not separate a slope from a colour</source>
   <translation>ist aus %1 beleuchtet, die eine Steigung nicht von einer Farbe trennen</translation>
  </message>
  <message>
   <source>Photograph it under lamps in three directions or more, from several sides</source>
   <translation>Unter Lampen in mindestens drei Richtungen von mehreren Seiten fotografieren</translation>
  </message>
  <message>
   <source>base colours are kept in %1; none lies beyond Rec.709</source>
   <translation>Grundfarben werden in %1 gehalten; keine liegt außerhalb von Rec.709</translation>
  </message>
  <message>
   <source>%1 of them lie beyond Rec.709 and are clipped by up to %2 of white</source>
   <translation>%1 davon liegen außerhalb von Rec.709 und werden um bis zu %2 von Weiß beschnitten</translation>
  </message>
  <message>
   <source>base colours are kept in %1; %2 in images and in exports that hold Rec.709 alone</source>
   <translation>Grundfarben werden in %1 gehalten; %2 in Bildern und in Exporten, die nur Rec.709 enthalten</translation>
  </message>
  <message>
   <source>%1 %2 is not a positive radiance</source>
   <translation>%1 %2 ist keine positive Strahldichte</translation>
  </message>
  <message>
   <source>%1 %2 seems to be an 8- or 16-bit level; the white level is 1, or its share of that where the reference is darker</source>
   <translation>%1 %2 scheint ein Wert von 8 oder 16 Bit zu sein; der Weißwert ist 1, oder sein Anteil daran, wo die Referenz dunkler ist</translation>
  </message>
  <message>
   <source>estimating errors of the rig</source>
   <translation>Fehler des Aufbaus werden geschätzt</translation>
  </message>
  <message>
   <source>Outlines within %1 of the surface are not closed: its heights are as uncertain as they differ</source>
   <translation>Umrisse innerhalb von %1 der Oberfläche sind nicht geschlossen: ihre Höhen sind so unsicher, wie sie voneinander abweichen</translation>
  </message>
  <message>
   <source>the lamps stand on one arc: only the slope along %1° is observed, across it the surface is </source>
   <translation>die Lampen stehen auf einem Bogen: nur die Steigung längs %1° ist sichtbar, quer dazu ist die Oberfläche </translation>
  </message>
  <message>
   <source>shown as flat, and there is no height</source>
   <translation>flach gezeigt, und es gibt keine Höhe</translation>
  </message>
  <message>
   <source>depth edges divide the surface into %1 regions, the largest with %2 of it: </source>
   <translation>Tiefenkanten teilen die Oberfläche in %1 Bereiche, der größte mit %2 davon: </translation>
  </message>
  <message>
   <source>%1the height steps between them by amounts that are unknown</source>
   <translation>%1die Höhenstufen dazwischen um unbekannte Beträge</translation>
  </message>
  <message>
   <source>%1 of the image is background, of which nothing is said</source>
   <translation>%1 des Bildes ist Hintergrund, über den nichts ausgesagt wird</translation>
  </message>
  <message>
   <source>%1 photographs do not resolve highlights: roughness and reflectance are those of plastic</source>
   <translation>%1 Fotos bestimmen keine Glanzlichter: Rauheit und Reflexionsgrad sind die von Kunststoff</translation>
  </message>
  <message>
   <source>a white reference that faces a lamp is taken to be %1 times as bright as the white level</source>
   <translation>eine Weißreferenz, die einer Lampe zugewandt ist, gilt als %1-mal so hell wie der Weißpegel</translation>
  </message>
  <message>
   <source>%1, because texels are brighter than a card at that level</source>
   <translation>%1, weil Texel heller sind als eine weiße Fläche bei diesem Pegel</translation>
  </message>
  <message>
   <source>held-out error is %1 8-bit levels, not at least 20 % lower than the %2 of the mean image</source>
   <translation>der zurückgehaltene Fehler beträgt %1 8-Bit-Stufen und liegt nicht mindestens 20 % unter den %2 des mittleren Bildes</translation>
  </message>
  <message>
   <source>%1: shadows, or lamps that are placed wrongly</source>
   <translation>%1: Schatten oder falsch angegebene Lampen</translation>
  </message>
  <message>
   <source>half of the normals are uncertain by more than %1° (1 sigma): the photographs do not fit the model</source>
   <translation>die Hälfte der Normalen ist um mehr als %1° unsicher (1 Sigma): die Fotos passen nicht zum Modell</translation>
  </message>
  <message>
   <source>%1 of a lit surface, or lamps are placed wrongly</source>
   <translation>%1 einer beleuchteten Fläche, oder Lampen sind falsch angegeben</translation>
  </message>
  <message>
   <source>looking for texels that are alike</source>
   <translation>ähnliche Texel werden gesucht</translation>
  </message>
  <message>
   <source>fitting a sample of texels</source>
   <translation>eine Stichprobe der Texel wird angepasst</translation>
  </message>
  <message>
   <source>leaving neighbouring lamps out</source>
   <translation>benachbarte Lampen werden zurückgehalten</translation>
  </message>
  <message>
   <source>finding slopes and reflectance</source>
   <translation>Steigungen und Reflexion werden bestimmt</translation>
  </message>
  <message>
   <source>The lights were estimated from the photographs alone: normals may share an error of %1° (1 sigma)</source>
   <translation>Die Lichter wurden allein aus den Fotos geschätzt: Normalen können gemeinsam um %1° abweichen (1 Sigma)</translation>
  </message>
  <message>
   <source>The samples of the photographs seem to be %1: import again with --transfer %2</source>
   <translation>Die Abtastwerte der Fotos scheinen %1 zu sein: mit --transfer %2 neu importieren</translation>
  </message>
  <message>
   <source>The lights were estimated as distant, equally bright lamps in a dark room, which the photographs contradict (%1). Estimated lights cannot be calibrated: import again with a list of lights or a mirror sphere</source>
   <translation>Die Lichter wurden als ferne, gleich helle Lampen in einem dunklen Raum geschätzt, dem die Fotos widersprechen (%1). Geschätzte Lichter lassen sich nicht kalibrieren: mit einer Lichterliste oder einer Spiegelkugel neu importieren</translation>
  </message>
  <message>
   <source>Import again with --calibrate auto</source>
   <translation>Mit --calibrate auto neu importieren</translation>
  </message>
  <message>
   <source>Not corrected for: %1. %2</source>
   <translation>Nicht korrigiert: %1. %2</translation>
  </message>
  <message>
   <source>writing %1</source>
   <translation>%1 wird geschrieben</translation>
  </message>
 </context>
 <context>
  <name>engine/scene</name>
  <message>
   <source>the %1 of a material is one line of at most %2 characters</source>
   <translation>%1 eines Materials: eine Zeile mit höchstens %2 Zeichen</translation>
  </message>
  <message>
   <source>lights that stand for the environment</source>
   <translation>Lichter, die die Umgebung darstellen</translation>
  </message>
  <message>
   <source>The photographs of the material under every light, without shadows</source>
   <translation>Die Fotos des Materials unter jedem Licht, ohne Schatten</translation>
  </message>
  <message>
   <source>Mat.</source>
   <translation>Mat.</translation>
  </message>
  <message>
   <source>whether two numbers for each texel take the place of the slices</source>
   <translation>ob zwei Zahlen je Texel an die Stelle der Schichten treten</translation>
  </message>
  <message>
   <source>Direct</source>
   <translation>Direkt</translation>
  </message>
  <message>
   <source>The BRDF alone under every light, with the shadows of all lights</source>
   <translation>Nur die BRDF unter jedem Licht, mit den Schatten aller Lichter</translation>
  </message>
  <message>
   <source>Path tracing with shadows; its noise falls with time</source>
   <translation>Pfadverfolgung mit Schatten; ihr Rauschen nimmt mit der Zeit ab</translation>
  </message>
  <message>
   <source>Ref.</source>
   <translation>Ref.</translation>
  </message>
  <message>
   <source>paths for each pixel</source>
   <translation>Pfade je Pixel</translation>
  </message>
  <message>
   <source>unknown source %1, form %2 or region above %3</source>
   <translation>unbekannte Quelle %1, Form %2 oder Bereich oberhalb %3</translation>
  </message>
  <message>
   <source>an irradiance of %1 is outside 0 … %2</source>
   <translation>eine Bestrahlungsstärke von %1 liegt nicht zwischen 0 und %2</translation>
  </message>
  <message>
   <source>unknown tiling mode %1; choose from %2</source>
   <translation>unbekannter Kachelmodus %1; möglich: %2</translation>
  </message>
  <message>
   <source>%1 repeats are not a positive number</source>
   <translation>%1 Wiederholungen sind keine positive Zahl</translation>
  </message>
  <message>
   <source>a rotation of %1 or %2 directions (1 … %3) is not possible</source>
   <translation>eine Drehung von %1 oder %2 Richtungen (1 … %3) ist nicht möglich</translation>
  </message>
  <message>
   <source>a scene has at most %1 lamps, not %2</source>
   <translation>eine Szene hat höchstens %1 Lichter, nicht %2</translation>
  </message>
  <message>
   <source>Angle of the light around the vertical.</source>
   <translation>Winkel des Lichts um die Senkrechte.</translation>
  </message>
  <message>
   <source>Irradiance of the light, or the factor on the environment.</source>
   <translation>Bestrahlungsstärke des Lichts oder Faktor auf die Umgebung.</translation>
  </message>
  <message>
   <source>Rotation of the environment about +Y.</source>
   <translation>Drehung der Umgebung um +Y.</translation>
  </message>
  <message>
   <source>Repetitions of the material over one unit of texture coordinates.</source>
   <translation>Wiederholungen des Materials über eine Einheit der Texturkoordinaten.</translation>
  </message>
 </context>
 <context>
  <name>engine/transport</name>
  <message>
   <source>one reflectance</source>
   <translation>ein Reflexionsverhalten</translation>
  </message>
  <message>
   <source>%1 reflectances, of which the first has the rest</source>
   <translation>%1 Reflexionsverhalten, von denen das erste den Rest hat</translation>
  </message>
  <message>
   <source>%1 weights do not fit %2</source>
   <translation>%1 Gewichte passen nicht zu %2</translation>
  </message>
  <message>
   <source>%1 is not of the form BRDF:SOURCE, say ggx:alpha=0.1:y or phong:mask.png</source>
   <translation>%1 hat nicht die Form BRDF:SOURCE, etwa ggx:alpha=0.1:y oder phong:mask.png</translation>
  </message>
  <message>
   <source>factors over different maps cannot be mixed; give their reflectances, or equal maps</source>
   <translation>Faktoren über verschiedenen Karten lassen sich nicht mischen; gleiche Karten verwenden</translation>
  </message>
  <message>
   <source>a lamp</source>
   <translation>ein Licht</translation>
  </message>
  <message>
   <source>too bright</source>
   <translation>zu hell</translation>
  </message>
  <message>
   <source>too dark</source>
   <translation>zu dunkel</translation>
  </message>
  <message>
   <source>%1 of its pixels below a tenth of the reference</source>
   <translation>%1 seiner Pixel unter einem Zehntel der Referenz</translation>
  </message>
  <message>
   <source>this bake was not compared with the reference</source>
   <translation>diese Vorberechnung wurde nicht mit der Referenz verglichen</translation>
  </message>
  <message>
   <source>%1 under %2</source>
   <translation>%1 unter %2</translation>
  </message>
  <message>
   <source>error of %1 small views against the reference: %2</source>
   <translation>Fehler von %1 kleinen Ansichten gegenüber der Referenz: %2</translation>
  </message>
  <message>
   <source>under %1 %2</source>
   <translation>unter %1 %2</translation>
  </message>
  <message>
   <source>in the mode %1 this bake differs from the reference: %2%3</source>
   <translation>im Modus %1 weicht diese Vorberechnung von der Referenz ab: %2%3</translation>
  </message>
  <message>
   <source>under this light</source>
   <translation>unter diesem Licht</translation>
  </message>
  <message>
   <source>under %1</source>
   <translation>unter %1</translation>
  </message>
  <message>
   <source>, the nearest light that was checked,</source>
   <translation>, dem nächsten geprüften Licht,</translation>
  </message>
  <message>
   <source>in the mode %1 this bake differs from the reference: %2 %3%4</source>
   <translation>im Modus %1 weicht diese Vorberechnung von der Referenz ab: %2 %3%4</translation>
  </message>
  <message>
   <source>; the mode %1 passes %2</source>
   <translation>; der Modus %1 übersteht %2</translation>
  </message>
  <message>
   <source>is damaged: the checksum of its check does not fit</source>
   <translation>ist beschädigt: die Prüfsumme seiner Prüfung stimmt nicht</translation>
  </message>
  <message>
   <source>its check</source>
   <translation>seine Prüfung</translation>
  </message>
  <message>
   <source>holds a check with impossible values</source>
   <translation>enthält eine Prüfung mit unmöglichen Werten</translation>
  </message>
  <message>
   <source>Baking</source>
   <translation>Vorberechnung</translation>
  </message>
  <message>
   <source>baking %1 vertices</source>
   <translation>%1 Eckpunkte werden vorberechnet</translation>
  </message>
  <message>
   <source>baking vertex %1 of %2, %3</source>
   <translation>Eckpunkt %1 von %2 wird vorberechnet, %3</translation>
  </message>
  <message>
   <source>Install Lightarc %1 where the scheduler and the workers run and start again; the bake goes on where it stopped</source>
   <translation>Lightarc %1 installieren, wo Scheduler und Worker laufen, und neu starten; die Vorberechnung geht weiter, wo sie anhielt</translation>
  </message>
  <message>
   <source>brushing %1</source>
   <translation>Bürstung %1</translation>
  </message>
  <message>
   <source>was baked for another mesh (%1)</source>
   <translation>wurde für ein anderes Netz vorberechnet (%1)</translation>
  </message>
  <message>
   <source>Bake this mesh</source>
   <translation>Dieses Netz vorberechnen</translation>
  </message>
  <message>
   <source>holds a mesh that cannot be (%1)</source>
   <translation>enthält ein unmögliches Netz (%1)</translation>
  </message>
  <message>
   <source>holds transport of the mode %1</source>
   <translation>enthält Transport des Modus %1</translation>
  </message>
  <message>
   <source>Bake with --mode %1</source>
   <translation>Mit --mode %1 vorberechnen</translation>
  </message>
  <message>
   <source>holds transport that cannot be (%1)</source>
   <translation>enthält unmöglichen Transport (%1)</translation>
  </message>
  <message>
   <source>Bake the mesh again</source>
   <translation>Das Netz neu vorberechnen</translation>
  </message>
  <message>
   <source>is not a transport file</source>
   <translation>ist keine Transportdatei</translation>
  </message>
  <message>
   <source>Give one that lightarc bake made</source>
   <translation>Eine von lightarc bake erzeugte angeben</translation>
  </message>
  <message>
   <source>Give a transport file that lightarc bake made</source>
   <translation>Eine von lightarc bake erzeugte Transportdatei angeben</translation>
  </message>
  <message>
   <source>Check the name</source>
   <translation>Den Namen prüfen</translation>
  </message>
  <message>
   <source>is damaged: the checksum of its header does not fit</source>
   <translation>ist beschädigt: die Prüfsumme seines Kopfs stimmt nicht</translation>
  </message>
  <message>
   <source>its header</source>
   <translation>sein Kopf</translation>
  </message>
  <message>
   <source>has a header with a faulty %1 (%2)</source>
   <translation>hat einen Kopf mit fehlerhaftem %1 (%2)</translation>
  </message>
  <message>
   <source>has a header that puts %1 where something else is</source>
   <translation>hat einen Kopf, der %1 dorthin setzt, wo etwas anderes ist</translation>
  </message>
  <message>
   <source>has a header whose arrays do not fit its size</source>
   <translation>hat einen Kopf, dessen Felder nicht zu seiner Größe passen</translation>
  </message>
  <message>
   <source>is damaged: the checksum of %1 does not fit</source>
   <translation>ist beschädigt: die Prüfsumme von %1 stimmt nicht</translation>
  </message>
  <message>
   <source>is damaged or was never finished: the table of its chunks does not fit</source>
   <translation>ist beschädigt oder wurde nie fertig: die Tabelle seiner Blöcke stimmt nicht</translation>
  </message>
  <message>
   <source>has bounds of chunks that cannot be</source>
   <translation>hat unmögliche Grenzen von Blöcken</translation>
  </message>
  <message>
   <source>has arrays with another number of rows than chunks</source>
   <translation>hat Felder mit einer anderen Zahl von Zeilen als Blöcken</translation>
  </message>
  <message>
   <source>is damaged: the checksum of chunk %1 does not fit</source>
   <translation>ist beschädigt: die Prüfsumme von Block %1 stimmt nicht</translation>
  </message>
  <message>
   <source>visibility of vertex %1 of %2</source>
   <translation>Sichtbarkeit von Eckpunkt %1 von %2</translation>
  </message>
  <message>
   <source>an occluder of %1 cells a side is outside %2 … %3</source>
   <translation>ein Verdecker mit %1 Zellen je Kante liegt außerhalb von %2 … %3</translation>
  </message>
  <message>
   <source>declares %1 bytes in %2, more than it can hold</source>
   <translation>gibt %1 Bytes in %2 an, mehr, als es enthalten kann</translation>
  </message>
  <message>
   <source>is damaged or cut short: the table of its blocks does not fit</source>
   <translation>ist beschädigt oder abgeschnitten: die Tabelle seiner Blöcke stimmt nicht</translation>
  </message>
  <message>
   <source>is damaged: its blocks do not fit its size</source>
   <translation>ist beschädigt: seine Blöcke passen nicht zu seiner Größe</translation>
  </message>
  <message>
   <source>is damaged: the checksum of a block of %1 does not fit</source>
   <translation>ist beschädigt: die Prüfsumme eines Blocks von %1 stimmt nicht</translation>
  </message>
  <message>
   <source>is damaged: a block of %1 cannot be unpacked (%2)</source>
   <translation>ist beschädigt: ein Block von %1 lässt sich nicht entpacken (%2)</translation>
  </message>
  <message>
   <source>the model has %1 parts with %2 different BRDFs; at most %3 parts with %4 are baked: give one --material FILE#NAME or --brdf for all</source>
   <translation>das Modell hat %1 Teile mit %2 verschiedenen BRDFs; vorberechnet werden höchstens %3 Teile mit %4: ein --material FILE#NAME oder --brdf für alle angeben</translation>
  </message>
  <message>
   <source>the parts of the model in %1 have BRDFs of their own; bake the model with another</source>
   <translation>die Teile des Modells in %1 haben eigene BRDFs; das Modell mit einer anderen vorberechnen</translation>
  </message>
  <message>
   <source>coefficients in the file are rounded, by %1 RMS</source>
   <translation>Koeffizienten in der Datei sind gerundet, um %1 RMS</translation>
  </message>
  <message>
   <source>; %1 %2 in the mean</source>
   <translation>; %1 %2 im Mittel</translation>
  </message>
  <message>
   <source>error under %1: %2 of the radiance (RMS, %3 pairs of vertex and view)%4</source>
   <translation>Fehler unter %1: %2 der Strahldichte (RMS, %3 Paare von Eckpunkt und Blick)%4</translation>
  </message>
  <message>
   <source>As planned</source>
   <translation>Wie geplant</translation>
  </message>
  <message>
   <source>With</source>
   <translation>Mit</translation>
  </message>
  <message>
   <source>N × N rays for each texel of the cube map at the edges of shadows</source>
   <translation>N × N Strahlen je Texel der Würfelkarte an Schattenkanten</translation>
  </message>
  <message>
   <source>edge of the cube map that visibility is counted over (32, above order 8 64)</source>
   <translation>Kante der Würfelkarte, über der Sichtbarkeit gezählt wird (32, über Ordnung 8 64)</translation>
  </message>
  <message>
   <source>bands of the spherical harmonics: more of them keep sharper light and highlights</source>
   <translation>Bänder der Kugelfunktionen: mehr behalten schärferes Licht und schärfere Glanzlichter</translation>
  </message>
  <message>
   <source>include interreflection between parts of the model</source>
   <translation>Wechselreflexion zwischen Teilen des Modells einschließen</translation>
  </message>
  <message>
   <source>Hanning</source>
   <translation>Hanning</translation>
  </message>
  <message>
   <source>Lanczos</source>
   <translation>Lanczos</translation>
  </message>
  <message>
   <source>damp high bands against ringing, at the price of blurred light</source>
   <translation>hohe Bänder gegen Überschwinger dämpfen, auf Kosten unschärferen Lichts</translation>
  </message>
  <message>
   <source>points along the longest side of the grid at which light of near lamps is found; between them it is interpolated (as many as keep the error below 1 %%)</source>
   <translation>Punkte längs der längsten Seite des Gitters, an denen das Licht naher Lampen bestimmt wird; dazwischen wird interpoliert (so viele, dass der Fehler unter 1 % bleibt)</translation>
  </message>
  <message>
   <source>vary a parameter of the BRDF over the model, as in lightarc bake; twice at most</source>
   <translation>einen Parameter der BRDF über das Modell variieren, wie bei „lightarc bake“; höchstens zweimal</translation>
  </message>
  <message>
   <source>terms, products of a light and a view map, of the BRDF: glossy ones need more</source>
   <translation>Terme, Produkte einer Licht- und einer Blickkarte, der BRDF: glänzende brauchen mehr</translation>
  </message>
  <message>
   <source>wavelet coefficients kept for each vertex and term: more keep more shadow</source>
   <translation>behaltene Wavelet-Koeffizienten je Eckpunkt und Term: mehr behalten mehr Schatten</translation>
  </message>
  <message>
   <source>edge of the cube map of the light: more texels keep sharper shadows</source>
   <translation>Kante der Würfelkarte des Lichts: mehr Texel behalten schärfere Schatten</translation>
  </message>
  <message>
   <source>128 cells</source>
   <translation>128 Zellen</translation>
  </message>
  <message>
   <source>64 cells</source>
   <translation>64 Zellen</translation>
  </message>
  <message>
   <source>32 cells</source>
   <translation>32 Zellen</translation>
  </message>
  <message>
   <source>shaded by</source>
   <translation>schattiert mit</translation>
  </message>
  <message>
   <source>let shadows fall from a model simplified in a grid of N cells a side, with quicker rays (0: the model)</source>
   <translation>Schatten eines vereinfachten Modells mit N Zellen je Seite verwenden, mit schnelleren Strahlen (0: das Modell)</translation>
  </message>
  <message>
   <source>of the BRDF's textures; polar suits single terms of anisotropic ones</source>
   <translation>der Texturen der BRDF; polar passt zu einzelnen Termen anisotroper</translation>
  </message>
  <message>
   <source>norm in which terms are found; auto: the one with the lower cosine-weighted error</source>
   <translation>Norm, in der Terme gesucht werden; auto: die mit dem kleineren kosinusgewichteten Fehler</translation>
  </message>
  <message>
   <source>signed terms have the least squared error and may sum to less than black; nonnegative ones never do, and are nearer to dark values; auto: nonnegative ones where their errors are smaller</source>
   <translation>vorzeichenbehaftete Terme haben den kleinsten quadratischen Fehler und können unter Schwarz fallen; nichtnegative nie, und sie sind näher an dunklen Werten; auto: nichtnegative, wo ihre Fehler kleiner sind</translation>
  </message>
  <message>
   <source>mix in another BRDF with its own terms; its weight over the model is x, y or z across its bounding box or the luminance of an image at its texture coordinates: ggx:alpha=0.1:y; --brdf has what is left; can be given several times</source>
   <translation>eine andere BRDF mit eigenen Termen beimischen; ihr Gewicht über das Modell ist x, y oder z durch seinen Quader oder die Leuchtdichte eines Bildes an seinen Texturkoordinaten</translation>
  </message>
  <message>
   <source>multiply the outgoing radiance by an image at the texture coordinates</source>
   <translation>die ausgehende Strahldichte an den Texturkoordinaten mit einem Bild multiplizieren</translation>
  </message>
  <message>
   <source>of the second BRDF of a bake with --blend (again for the third), in place of what was baked: x, y, z or a image</source>
   <translation>der zweiten BRDF einer Vorberechnung mit --blend (wiederholt für die dritte), anstelle der vorberechneten: x, y, z oder ein Bild</translation>
  </message>
  <message>
   <source>multiply the outgoing radiance by an image at the texture coordinates, in place of what was baked</source>
   <translation>die ausgehende Strahldichte mit einem Bild an den Texturkoordinaten multiplizieren, anstelle des vorberechneten</translation>
  </message>
  <message>
   <source>Gaussians for each vertex and view: more follow partly shaded highlights</source>
   <translation>Gauß-Funktionen je Eckpunkt und Ansicht: mehr folgen teilweise verschatteten Glanzlichtern</translation>
  </message>
  <message>
   <source>include indirect glossy transfer</source>
   <translation>indirekten glänzenden Transport einschließen</translation>
  </message>
  <message>
   <source>directions of view, an icosahedron cut in three</source>
   <translation>Blickrichtungen, ein dreifach unterteiltes Ikosaeder</translation>
  </message>
  <message>
   <source>directions that each highlight is tabulated at</source>
   <translation>Richtungen, an denen jedes Glanzlicht tabelliert wird</translation>
  </message>
  <message>
   <source>bands of the spherical harmonics of the diffuse part</source>
   <translation>Bänder der Kugelfunktionen des diffusen Anteils</translation>
  </message>
  <message>
   <source>edge of the cube map that visibility is counted over (64)</source>
   <translation>Kante der Würfelkarte, über die die Sichtbarkeit gezählt wird (64)</translation>
  </message>
  <message>
   <source>heights of the Gaussians: nearest to the highlight, or with all its energy; auto: the lower error of the radiance under --error-env, or in the studio</source>
   <translation>Höhen der Gauß-Funktionen: dem Glanzlicht am nächsten oder mit seiner ganzen Energie; auto: der kleinere Fehler der Strahldichte</translation>
  </message>
  <message>
   <source>store Gaussians in 8 bytes or fewer instead of 28</source>
   <translation>Gauß-Funktionen in höchstens 8 statt 28 Bytes speichern</translation>
  </message>
  <message>
   <source>%1 cannot go from %2 to %3</source>
   <translation>%1 kann nicht von %2 bis %3 gehen</translation>
  </message>
  <message>
   <source>a variation needs the name of a parameter and a source</source>
   <translation>eine Variation braucht den Namen eines Parameters und eine Quelle</translation>
  </message>
  <message>
   <source>%1 is not of the form PARAMETER=FROM:TO:SOURCE, say alpha=0.1:0.5:y</source>
   <translation>%1 hat nicht die Form PARAMETER=FROM:TO:SOURCE, etwa alpha=0.1:0.5:y</translation>
  </message>
  <message>
   <source>only analytic models have parameters that can vary over a surface</source>
   <translation>nur analytische Modelle haben Parameter, die über eine Oberfläche variieren können</translation>
  </message>
  <message>
   <source>the BRDF has no parameter %1; it has %2</source>
   <translation>die BRDF hat keinen Parameter %1; sie hat %2</translation>
  </message>
  <message>
   <source>%1 is to vary twice</source>
   <translation>%1 soll zweimal variieren</translation>
  </message>
  <message>
   <source>visibility %1</source>
   <translation>Sichtbarkeit %1</translation>
  </message>
  <message>
   <source>looking at the BRDF</source>
   <translation>BRDF wird untersucht</translation>
  </message>
  <message>
   <source>this BRDF has no glossy part; bake it with --mode sh or wavelet</source>
   <translation>diese BRDF hat keinen glänzenden Anteil; mit Kugelfunktionen oder Wavelets vorberechnen</translation>
  </message>
  <message>
   <source>fitting some vertices to see how long it takes</source>
   <translation>einige Eckpunkte werden angepasst, um die Dauer zu schätzen</translation>
  </message>
  <message>
   <source>preparing %1 vertices, %2</source>
   <translation>%1 Eckpunkte werden vorbereitet, %2</translation>
  </message>
  <message>
   <source>baking the diffuse part</source>
   <translation>diffuser Anteil wird vorberechnet</translation>
  </message>
  <message>
   <source>casting rays</source>
   <translation>Strahlen werden verfolgt</translation>
  </message>
  <message>
   <source>comparing with the sum over all texels</source>
   <translation>Vergleich mit der Summe über alle Texel</translation>
  </message>
  <message>
   <source>%1 lobes are not possible; 1 to %2 are</source>
   <translation>%1 Keulen sind nicht möglich; möglich sind 1 bis %2</translation>
  </message>
  <message>
   <source>the weights of the energies must be from 0 to 1,000,000</source>
   <translation>die Gewichte der Energien müssen von 0 bis 1.000.000 sein</translation>
  </message>
  <message>
   <source>%1 sweeps and %2 relaxations are not possible</source>
   <translation>%1 Durchläufe und %2 Relaxationen sind nicht möglich</translation>
  </message>
  <message>
   <source>%1 steps are not possible; each is from 0 to 1,000</source>
   <translation>%1 Schritte sind nicht möglich; jeweils 0 bis 1.000</translation>
  </message>
  <message>
   <source>fitting vertex %1 of %2</source>
   <translation>Eckpunkt %1 von %2 wird angepasst</translation>
  </message>
  <message>
   <source>fitting %1 vertices again</source>
   <translation>%1 Eckpunkte werden neu angepasst</translation>
  </message>
  <message>
   <source>making neighbours agree</source>
   <translation>Nachbarn werden in Übereinstimmung gebracht</translation>
  </message>
  <message>
   <source>fitting single views of %1 vertices again</source>
   <translation>einzelne Ansichten von %1 Eckpunkten werden neu angepasst</translation>
  </message>
  <message>
   <source>%1 of %2 pairs of neighbours disagree on their lobes</source>
   <translation>%1 von %2 Nachbarpaaren haben nicht dieselben Keulen</translation>
  </message>
  <message>
   <source>%1 vertices reflect no light towards any view</source>
   <translation>%1 Eckpunkte reflektieren in keine Ansicht Licht</translation>
  </message>
  <message>
   <source>a factor of %1 or a rotation of %2 rad is not possible</source>
   <translation>ein Faktor von %1 oder eine Drehung von %2 rad ist nicht möglich</translation>
  </message>
  <message>
   <source>Gaussians cannot bake parts of which only some have an Ashikhmin-Shirley BRDF; choose --mode sh or wavelet</source>
   <translation>Gauß-Funktionen können keine Teile vorberechnen, von denen nur einige eine Ashikhmin-Shirley-BRDF haben; --mode sh oder wavelet wählen</translation>
  </message>
  <message>
   <source>parameters of the BRDF of %1 vary over the model; bake again with another</source>
   <translation>Parameter der BRDF von %1 variieren über das Modell; mit einer anderen neu vorberechnen</translation>
  </message>
  <message>
   <source>%1 pairs of neighbours disagree on which Gaussian is which.</source>
   <translation>%1 Nachbarpaare stimmen nicht überein, welche Gauß-Funktion welche ist.</translation>
  </message>
  <message>
   <source>No light between parts of the model; --indirect adds it.</source>
   <translation>Kein Licht zwischen Teilen des Modells; --indirect fügt es hinzu.</translation>
  </message>
  <message>
   <source>nearest to the highlights</source>
   <translation>den Glanzlichtern am nächsten</translation>
  </message>
  <message>
   <source>with all their energy</source>
   <translation>mit ihrer ganzen Energie</translation>
  </message>
  <message>
   <source>Gaussians %1: error %2 plain, %3 with all energy; off the highlights themselves by %4 on average, %5 for the worst hundredth</source>
   <translation>Gauß-Funktionen %1: Fehler %2 ohne, %3 mit ganzer Energie; von den Glanzlichtern selbst weichen sie im Mittel um %4 ab, im schlechtesten Hundertstel um %5</translation>
  </message>
  <message>
   <source>Gaussians take %1 instead of %2, which changes the radiance by %3</source>
   <translation>Gauß-Funktionen nehmen %1 statt %2, was die Strahldichte um %3 ändert</translation>
  </message>
  <message>
   <source>The bake is of another BRDF; Gaussians are baked for one.</source>
   <translation>Die Vorberechnung gehört zu einer anderen BRDF; Gauß-Funktionen gelten für eine.</translation>
  </message>
  <message>
   <source>filtering the light</source>
   <translation>Licht wird gefiltert</translation>
  </message>
  <message>
   <source>bake the diffuse part with a higher --order</source>
   <translation>den diffusen Anteil mit höherem --order vorberechnen</translation>
  </message>
  <message>
   <source>parameters vary over a model of one BRDF, and this one has materials for its parts; choose one with --material FILE#NAME or --brdf, or let nothing vary</source>
   <translation>Parameter variieren über ein Modell mit einer BRDF, und dieses hat Materialien für seine Teile; mit --material FILE#NAME oder --brdf eines wählen oder nichts variieren</translation>
  </message>
  <message>
   <source>--mode %1 bakes one BRDF, and the model has materials for its parts; choose one with --material FILE#NAME or --brdf</source>
   <translation>--mode %1 berechnet eine BRDF vor, und das Modell hat Materialien für seine Teile; mit --material FILE#NAME oder --brdf eines wählen</translation>
  </message>
  <message>
   <source>Spherical harmonics</source>
   <translation>Kugelfunktionen</translation>
  </message>
  <message>
   <source>spherical harmonics</source>
   <translation>Kugelfunktionen</translation>
  </message>
  <message>
   <source>Baked spherical harmonics: shadows under any soft light</source>
   <translation>Vorberechnete Kugelfunktionen: Schatten unter jedem weichen Licht</translation>
  </message>
  <message>
   <source>Wavelets</source>
   <translation>Wavelets</translation>
  </message>
  <message>
   <source>Baked wavelets: sharp shadows under any light</source>
   <translation>Vorberechnete Wavelets: scharfe Schatten unter jedem Licht</translation>
  </message>
  <message>
   <source>Wavel</source>
   <translation>Wavel</translation>
  </message>
  <message>
   <source>Gaussians</source>
   <translation>Gauß-Funktionen</translation>
  </message>
  <message>
   <source>Baked Gaussians: sharp highlights under any light</source>
   <translation>Vorberechnete Gauß-Funktionen: scharfe Glanzlichter unter jedem Licht</translation>
  </message>
  <message>
   <source>Gauss</source>
   <translation>Gauß</translation>
  </message>
  <message>
   <source>reading visibility</source>
   <translation>Sichtbarkeit wird gelesen</translation>
  </message>
  <message>
   <source>--brdf is part of the bake %1, and its visibility is not kept on this machine; bake again with the other BRDF, which takes about %2</source>
   <translation>--brdf ist Teil der Vorberechnung %1, deren Sichtbarkeit auf diesem Rechner nicht aufbewahrt ist; mit der anderen BRDF neu vorberechnen, was etwa %2 dauert</translation>
  </message>
  <message>
   <source>%1 bounces (0 … 16) of %2 rays (16 … 65536) are not possible</source>
   <translation>%1 Reflexionen (0 … 16) mit %2 Strahlen (16 … 65536) sind nicht möglich</translation>
  </message>
  <message>
   <source>light between parts of a model that does not shade itself is not possible</source>
   <translation>Licht zwischen Teilen eines Modells, das sich nicht selbst verschattet, ist nicht möglich</translation>
  </message>
  <message>
   <source>Its spherical harmonics have an error of %1: the BRDF is too narrow or too uneven.</source>
   <translation>Ihre Kugelfunktionen haben einen Fehler von %1: die BRDF ist zu schmal oder zu ungleichmäßig.</translation>
  </message>
  <message>
   <source>projecting the BRDF</source>
   <translation>BRDF wird projiziert</translation>
  </message>
  <message>
   <source>Between its tables the varied BRDF has an error of up to %1.</source>
   <translation>Zwischen ihren Tabellen hat die variierte BRDF einen Fehler von bis zu %1.</translation>
  </message>
  <message>
   <source>%1 parameters are to vary; spherical harmonics have tables over 1 or 2</source>
   <translation>%1 Parameter sollen variieren; Kugelfunktionen haben Tabellen über 1 oder 2</translation>
  </message>
  <message>
   <source>table %1 of %2</source>
   <translation>Tabelle %1 von %2</translation>
  </message>
  <message>
   <source>looking where tables are needed, %1</source>
   <translation>nötige Tabellen werden gesucht, %1</translation>
  </message>
  <message>
   <source>tabulating the reflectance, %1</source>
   <translation>Reflexion wird tabelliert, %1</translation>
  </message>
  <message>
   <source>following bounce %1 of %2</source>
   <translation>Reflexion %1 von %2 wird verfolgt</translation>
  </message>
  <message>
   <source>a lamp that is a point lies on a vertex</source>
   <translation>ein punktförmiges Licht liegt auf einem Eckpunkt</translation>
  </message>
  <message>
   <source>%1 points along a side are outside 1 … %2</source>
   <translation>%1 Punkte je Kante liegen außerhalb von 1 … %2</translation>
  </message>
  <message>
   <source>a lamp is too bright for numbers of 32 bits</source>
   <translation>ein Licht ist zu hell für 32-Bit-Zahlen</translation>
  </message>
  <message>
   <source>the lamp at %1 of radius %2 touches the model, %3 from its centre</source>
   <translation>das Licht bei %1 mit Radius %2 berührt das Modell, %3 von seiner Mitte</translation>
  </message>
  <message>
   <source>the %1 at %2 touches the model</source>
   <translation>%1 bei %2 berührt das Modell</translation>
  </message>
  <message>
   <source>interreflection was baked for one BRDF</source>
   <translation>Wechselreflexion wurde für eine BRDF vorberechnet</translation>
  </message>
  <message>
   <source>a diffuse model was baked as vectors, which do not depend on the view</source>
   <translation>ein diffuses Modell wurde als Vektoren vorberechnet, die nicht vom Blick abhängen</translation>
  </message>
  <message>
   <source>a table of order %1 does not fit transport of order %2</source>
   <translation>eine Tabelle der Ordnung %1 passt nicht zu Transport der Ordnung %2</translation>
  </message>
  <message>
   <source>No matrices: a diffuse model looks the same from every side, and a vector does.</source>
   <translation>Keine Matrizen: ein diffuses Modell sieht von jeder Seite gleich aus, wie ein Vektor.</translation>
  </message>
  <message>
   <source>No light between parts of the model; --interreflection adds it.</source>
   <translation>Kein Licht zwischen Teilen des Modells; --interreflection fügt es hinzu.</translation>
  </message>
  <message>
   <source>Light between parts of the model counts as reflected evenly to all sides until the last time.</source>
   <translation>Licht zwischen Teilen des Modells gilt bis zum letzten Mal als gleichmäßig nach allen Seiten reflektiert.</translation>
  </message>
  <message>
   <source>the reflectance varies over %1 tables; between them it is off by up to %2</source>
   <translation>das Reflexionsverhalten variiert über %1 Tabellen; zwischen ihnen weicht es um bis zu %2 ab</translation>
  </message>
  <message>
   <source>The bake is of another BRDF; interreflection is baked for one.</source>
   <translation>Die Vorberechnung gehört zu einer anderen BRDF; Wechselreflexion gilt für eine.</translation>
  </message>
  <message>
   <source>A diffuse model was baked, which holds nothing of the view.</source>
   <translation>Ein diffuses Modell wurde vorberechnet, das nichts vom Blick enthält.</translation>
  </message>
  <message>
   <source>a higher order or --window rings less</source>
   <translation>eine höhere Ordnung oder --window schwingt weniger über</translation>
  </message>
  <message>
   <source>--near-points needs --near-lamp</source>
   <translation>--near-points braucht --near-lamp</translation>
  </message>
  <message>
   <source>Between the points where it was found, the light of near lamps is off by %1 RMS.</source>
   <translation>Zwischen den Stützpunkten weicht das Licht naher Lichter um %1 RMS ab.</translation>
  </message>
  <message>
   <source>The BRDF cannot be changed without another bake: %1</source>
   <translation>Die BRDF lässt sich nicht ohne neue Vorberechnung ändern: %1</translation>
  </message>
  <message>
   <source>interreflection is baked for one BRDF, not for one that varies or is coloured by an image</source>
   <translation>Wechselreflexion wird für eine BRDF vorberechnet, nicht für eine, die variiert oder von einem Bild gefärbt ist</translation>
  </message>
  <message>
   <source>comparing numbers of terms</source>
   <translation>Zahlen von Termen werden verglichen</translation>
  </message>
  <message>
   <source>wavelets need factors over light and viewer (in-out), not over half and difference vectors</source>
   <translation>Wavelets brauchen Faktoren über Licht und Blick, nicht über Halb- und Differenzvektoren</translation>
  </message>
  <message>
   <source>%1 terms are more than the %2 that can be baked</source>
   <translation>%1 Terme sind mehr als die %2, die sich vorberechnen lassen</translation>
  </message>
  <message>
   <source>--blend and --albedo are for a model of one BRDF; choose one with --material FILE#NAME</source>
   <translation>--blend und --albedo gelten für ein Modell mit einer BRDF; mit --material FILE#NAME eine wählen</translation>
  </message>
  <message>
   <source>factoring the BRDF</source>
   <translation>BRDF wird faktorisiert</translation>
  </message>
  <message>
   <source>%1 mixes several BRDFs; bake again with other ones</source>
   <translation>%1 mischt mehrere BRDFs; mit anderen neu vorberechnen</translation>
  </message>
  <message>
   <source>errors of vertices are those of direct light: interreflection is compared in the check alone</source>
   <translation>Fehler der Eckpunkte sind die des direkten Lichts: Wechselreflexion wird nur in der Prüfung verglichen</translation>
  </message>
  <message>
   <source>%1 of the %2 terms are not stored: they make no image better</source>
   <translation>%1 der %2 Terme werden nicht gespeichert: sie machen kein Bild besser</translation>
  </message>
  <message>
   <source>shadows from %1 triangles: the open share of the sky is off by %2 RMS, rays take %3 of the time</source>
   <translation>Schatten von %1 Dreiecken: der offene Anteil des Himmels weicht um %2 RMS ab, Strahlen brauchen %3 der Zeit</translation>
  </message>
  <message>
   <source>The bake is of another BRDF; wavelets are baked for one.</source>
   <translation>Die Vorberechnung gehört zu einer anderen BRDF; Wavelets gelten für eine.</translation>
  </message>
  <message>
   <source>bake the BRDF with --signs nonnegative, or factor it with --method nonnegative: those have no negative term</source>
   <translation>die BRDF mit --signs nonnegative vorberechnen oder mit --method nonnegative faktorisieren: die haben keinen negativen Term</translation>
  </message>
  <message>
   <source>preparing vectors</source>
   <translation>Vektoren werden vorbereitet</translation>
  </message>
 </context>
 <context>
  <name>engine/render</name>
  <message>
   <source>Rendering on the CPU</source>
   <translation>Berechnung auf der CPU</translation>
  </message>
  <message>
   <source>tone mapping %1 or exposure %2 EV (−40 … 40) is not possible</source>
   <translation>Tonwertabbildung %1 oder Belichtung %2 EV (−40 … 40) ist nicht möglich</translation>
  </message>
  <message>
   <source>Measuring the error of the directions</source>
   <translation>Fehler der Richtungen wird gemessen</translation>
  </message>
  <message>
   <source>albedo and normals</source>
   <translation>Albedo und Normalen</translation>
  </message>
  <message>
   <source>the form 'outgoing' depends on all light at once: no reference exists for it</source>
   <translation>die Form 'outgoing' hängt von allem Licht zugleich ab: dafür gibt es keine Referenz</translation>
  </message>
  <message>
   <source>Reference, %1 samples</source>
   <translation>Referenz, %1 Abtastungen</translation>
  </message>
  <message>
   <source>drawing on the CPU</source>
   <translation>Bild wird auf der CPU gezeichnet</translation>
  </message>
 </context>
 <context>
  <name>engine/gl</name>
  <message>
   <source>The BRDF is drawn from a table with an error of %1 RMS.</source>
   <translation>Die BRDF wird aus einer Tabelle mit einem Fehler von %1 RMS gezeichnet.</translation>
  </message>
  <message>
   <source>The BRDF is anisotropic and is drawn as its mean over all azimuths; the renderer on the CPU (--renderer cpu) shows it as it is.</source>
   <translation>Die BRDF ist anisotrop und wird als ihr Mittel über alle Azimute gezeichnet; der Renderer auf der CPU (--renderer cpu) zeigt sie, wie sie ist.</translation>
  </message>
  <message>
   <source>The material of %1 × %2 texels is shown at %3 × %4: %5 is the largest texture of this graphics device.</source>
   <translation>Das Material mit %1 × %2 Texeln wird mit %3 × %4 gezeigt: %5 ist die größte Textur dieser Grafikkarte.</translation>
  </message>
  <message>
   <source>Install a driver with OpenGL 3.3 (on Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri), or render on the CPU with --renderer cpu</source>
   <translation>Einen Treiber mit OpenGL 3.3 installieren (unter Debian und Ubuntu: apt install libegl1 libgl1-mesa-dri) oder mit --renderer cpu auf der CPU rendern</translation>
  </message>
  <message>
   <source>OpenGL 3.3 is not available (%1)</source>
   <translation>OpenGL 3.3 ist nicht verfügbar (%1)</translation>
  </message>
  <message>
   <source>The ground cannot be drawn: its shader does not compile; see the log.</source>
   <translation>Der Boden lässt sich nicht zeichnen: sein Shader kompiliert nicht; siehe Protokoll.</translation>
  </message>
  <message>
   <source>The light is drawn with at most %1 texels along a face</source>
   <translation>Das Licht wird mit höchstens %1 Texeln je Kante einer Fläche gezeichnet</translation>
  </message>
  <message>
   <source>Tiles that keep their slices are shown by the power law: the slices are too many.</source>
   <translation>Kacheln mit eigenen Schichten werden durch das Potenzgesetz gezeigt: es sind zu viele Schichten.</translation>
  </message>
  <message>
   <source>The %1 slices are shown as %2, the most that this graphics device can hold.</source>
   <translation>Die %1 Schichten werden als %2 gezeigt, mehr fasst diese Grafikkarte nicht.</translation>
  </message>
  <message>
   <source>has a loop whose condition declares a variable</source>
   <translation>hat eine Schleife, deren Bedingung eine Variable deklariert</translation>
  </message>
  <message>
   <source>Declare it before the loop</source>
   <translation>Sie vor der Schleife deklarieren</translation>
  </message>
  <message>
   <source>needs more than %1 iterations of its loops for one pair of directions</source>
   <translation>braucht für ein Richtungspaar mehr als %1 Durchläufe seiner Schleifen</translation>
  </message>
 </context>
 <context>
  <name>engine/accuracy</name>
  <message>
   <source>checking the bake</source>
   <translation>Vorberechnung wird geprüft</translation>
  </message>
  <message>
   <source>luminance, A − B</source>
   <translation>Leuchtdichte, A − B</translation>
  </message>
  <message>
   <source>comparing as an eye does</source>
   <translation>Bilder werden wahrnehmungsnah verglichen</translation>
  </message>
 </context>
 <context>
  <name>engine/planning</name>
  <message>
   <source>the mode %1 is not baked</source>
   <translation>der Modus %1 wird nicht vorberechnet</translation>
  </message>
  <message>
   <source>baking %1 settings on one set of rays</source>
   <translation>%1 Einstellungen werden mit denselben Strahlen vorberechnet</translation>
  </message>
  <message>
   <source>its bake</source>
   <translation>seine Vorberechnung</translation>
  </message>
  <message>
   <source>%1 takes about %2, for which there was no time</source>
   <translation>%1 dauert etwa %2; dafür war keine Zeit</translation>
  </message>
  <message>
   <source>it needs %1 of memory, more than is free</source>
   <translation>es braucht %1 Speicher, mehr als frei ist</translation>
  </message>
  <message>
   <source>a ceiling of %1 = %2 is not above 0</source>
   <translation>eine Obergrenze von %1 = %2 ist nicht über 0</translation>
  </message>
  <message>
   <source>%1 frames are too few</source>
   <translation>%1 Bilder sind zu wenige</translation>
  </message>
  <message>
   <source>format %1</source>
   <translation>Format %1</translation>
  </message>
  <message>
   <source>measuring frames, %1</source>
   <translation>Bilder werden gemessen, %1</translation>
  </message>
  <message>
   <source>%1 vertices, %2 pixels, %3 texels and a depth of %4</source>
   <translation>%1 Eckpunkte, %2 Pixel, %3 Texel und eine Tiefe von %4</translation>
  </message>
  <message>
   <source>measuring the speed of the CPU</source>
   <translation>Geschwindigkeit der CPU wird gemessen</translation>
  </message>
  <message>
   <source>measuring a frame</source>
   <translation>ein Bild wird gemessen</translation>
  </message>
  <message>
   <source>measuring rays</source>
   <translation>Strahlen werden gemessen</translation>
  </message>
  <message>
   <source>measuring bakes of spherical harmonics, order %1</source>
   <translation>Vorberechnungen in Kugelfunktionen werden gemessen, Ordnung %1</translation>
  </message>
  <message>
   <source>measuring bakes of wavelets</source>
   <translation>Vorberechnungen in Wavelets werden gemessen</translation>
  </message>
  <message>
   <source>measuring bakes of Gaussians</source>
   <translation>Vorberechnungen in Gauß-Funktionen werden gemessen</translation>
  </message>
  <message>
   <source>measuring rotated environments</source>
   <translation>gedrehte Umgebungen werden gemessen</translation>
  </message>
  <message>
   <source>measuring the reference</source>
   <translation>Referenz wird gemessen</translation>
  </message>
  <message>
   <source>Every vertex sees its whole hemisphere: nothing shades anything.</source>
   <translation>Jeder Eckpunkt sieht seine ganze Halbkugel: nichts wirft Schatten.</translation>
  </message>
  <message>
   <source>%1 of the vertices see less than their hemisphere, on average %2 of it; without shadows the error of direct light is %3.</source>
   <translation>%1 der Eckpunkte sehen weniger als ihre Halbkugel, im Mittel %2 davon; ohne Schatten ist der Fehler des direkten Lichts %3.</translation>
  </message>
  <message>
   <source>Every vertex sees its whole hemisphere: no part lights another.</source>
   <translation>Jeder Eckpunkt sieht seine ganze Halbkugel: kein Teil beleuchtet einen anderen.</translation>
  </message>
  <message>
   <source>An albedo of %1 and %2 of the view closed by other parts: their light is %3 of the image.</source>
   <translation>Eine Albedo von %1, und %2 der Sicht durch andere Teile verdeckt: ihr Licht macht %3 des Bildes aus.</translation>
  </message>
  <message>
   <source>The BRDF is Lambertian: it looks the same from every side.</source>
   <translation>Die BRDF ist lambertsch: sie sieht von allen Seiten gleich aus.</translation>
  </message>
  <message>
   <source>The error of a diffuse surface of equal albedo is %1.</source>
   <translation>Der Fehler einer diffusen Fläche gleicher Albedo ist %1.</translation>
  </message>
  <message>
   <source>The BRDF is isotropic.</source>
   <translation>Die BRDF ist isotrop.</translation>
  </message>
  <message>
   <source>The error of the mean over all azimuths is %1.</source>
   <translation>Der Fehler des Mittels über alle Azimute ist %1.</translation>
  </message>
  <message>
   <source>%1 spherical harmonics of this light have an error of %2 with this BRDF.</source>
   <translation>%1 Kugelfunktionen dieses Lichts haben mit dieser BRDF einen Fehler von %2.</translation>
  </message>
  <message>
   <source>The light has no tiny source that is many times as bright as all around it.</source>
   <translation>Das Licht hat keine winzige Quelle, die vielfach heller ist als ihre Umgebung.</translation>
  </message>
  <message>
   <source>One tiny bright source brings</source>
   <translation>Eine winzige helle Quelle bringt</translation>
  </message>
  <message>
   <source>%1 tiny bright sources bring</source>
   <translation>%1 winzige helle Quellen bringen</translation>
  </message>
  <message>
   <source>%1 %2 of the light; left in the map, the error of the image is %3.</source>
   <translation>%1 %2 des Lichts; bleibt sie in der Karte, ist der Fehler des Bildes %3.</translation>
  </message>
  <message>
   <source>No maps of a material: every point of the surface is alike.</source>
   <translation>Keine Karten eines Materials: jeder Punkt der Oberfläche ist gleich.</translation>
  </message>
  <message>
   <source>The texels of the material differ from their mean by %1.</source>
   <translation>Die Texel des Materials weichen um %1 von ihrem Mittel ab.</translation>
  </message>
  <message>
   <source>Texels of the maps differ: see mesostructure.</source>
   <translation>Texel der Karten unterscheiden sich: siehe Mesostruktur.</translation>
  </message>
  <message>
   <source>The surface has one BRDF.</source>
   <translation>Die Oberfläche hat eine BRDF.</translation>
  </message>
  <message>
   <source>%1 at its mean, %2,</source>
   <translation>%1 bei seinem Mittel, %2,</translation>
  </message>
  <message>
   <source>The BRDF varies over the surface; with %1 everywhere the error is %2.</source>
   <translation>Die BRDF variiert über die Oberfläche; mit %1 überall ist der Fehler %2.</translation>
  </message>
  <message>
   <source>The BRDF does not rise towards grazing views.</source>
   <translation>Die BRDF steigt bei streifendem Blick nicht an.</translation>
  </message>
  <message>
   <source>Its rise towards grazing views changes the image by %1; it costs nothing.</source>
   <translation>Ihr Anstieg bei streifendem Blick ändert das Bild um %1; er kostet nichts.</translation>
  </message>
  <message>
   <source>Nothing is sent back towards the light more than across it.</source>
   <translation>Zum Licht zurück geht nicht mehr als quer dazu.</translation>
  </message>
  <message>
   <source>What is sent back towards the light changes the image by %1; it costs nothing.</source>
   <translation>Was zum Licht zurückgeworfen wird, ändert das Bild um %1; es kostet nichts.</translation>
  </message>
  <message>
   <source>without a BRDF no more pixels are looked for than are kept</source>
   <translation>ohne BRDF werden nicht mehr Pixel gesucht, als behalten werden</translation>
  </message>
  <message>
   <source>analysing the scene</source>
   <translation>Szene wird untersucht</translation>
  </message>
  <message>
   <source>forced on</source>
   <translation>erzwungen</translation>
  </message>
  <message>
   <source>a plan has one budget: of error or of time</source>
   <translation>ein Plan hat ein Budget: Fehler oder Zeit</translation>
  </message>
  <message>
   <source>a budget of %1 of %2 is not above 0</source>
   <translation>ein Budget von %1 %2 ist nicht über 0</translation>
  </message>
  <message>
   <source>unknown effect %1%2; choose from %3</source>
   <translation>unbekannter Effekt %1%2; möglich: %3</translation>
  </message>
  <message>
   <source>%1 cannot be forced and skipped at once</source>
   <translation>%1 kann nicht zugleich erzwungen und ausgelassen werden</translation>
  </message>
  <message>
   <source>no mode is left to choose from in %1 of memory</source>
   <translation>mit %1 Speicher bleibt kein Modus zur Wahl</translation>
  </message>
  <message>
   <source>%1 cannot be forced on a reflectance that varies and does not have it</source>
   <translation>%1 lässt sich bei variierendem Reflexionsverhalten ohne diesen Effekt nicht erzwingen</translation>
  </message>
  <message>
   <source>forced off</source>
   <translation>ausgelassen</translation>
  </message>
  <message>
   <source>%1 The error of the whole plan is %2.</source>
   <translation>%1 Der Fehler des ganzen Plans ist %2.</translation>
  </message>
  <message>
   <source>%1 The mode %2 shows it of lamps and suns alone.</source>
   <translation>%1 Der Modus %2 zeigt es nur für gerichtete Lichter und Sonnen.</translation>
  </message>
  <message>
   <source>%1 The mode %2 does not show it.</source>
   <translation>%1 Der Modus %2 zeigt es nicht.</translation>
  </message>
  <message>
   <source>measuring small images</source>
   <translation>kleine Bilder werden gemessen</translation>
  </message>
 </context>
 <context>
  <name>engine/tradeoff</name>
  <message>
   <source>none (drawn on the CPU)</source>
   <translation>keine (auf der CPU gezeichnet)</translation>
  </message>
  <message>
   <source>a budget of %1 = %2 is not above 0</source>
   <translation>ein Budget von %1 = %2 ist nicht über 0</translation>
  </message>
  <message>
   <source>%1 is not a budget such as '8 ms and 100 MB' or '1 %'</source>
   <translation>%1 ist kein Budget wie „8 ms and 100 MB“ oder „1 %“</translation>
  </message>
  <message>
   <source>%1 of %2 settings keep within it</source>
   <translation>%1 von %2 Einstellungen halten es ein</translation>
  </message>
  <message>
   <source>Nothing has been measured yet</source>
   <translation>Noch nichts gemessen</translation>
  </message>
  <message>
   <source>the least error is %1</source>
   <translation>der kleinste Fehler ist %1</translation>
  </message>
  <message>
   <source>the quickest takes %1</source>
   <translation>die schnellste braucht %1</translation>
  </message>
  <message>
   <source>the smallest takes %1</source>
   <translation>die kleinste braucht %1</translation>
  </message>
  <message>
   <source>each limit can be kept alone, but not all of them together</source>
   <translation>jede Grenze lässt sich allein einhalten, aber nicht alle zusammen</translation>
  </message>
  <message>
   <source>No measured setting keeps within it: %1</source>
   <translation>Keine gemessene Einstellung hält es ein: %1</translation>
  </message>
  <message>
   <source>Time of a frame</source>
   <translation>Zeit eines Bildes</translation>
  </message>
  <message>
   <source>Time to relight</source>
   <translation>Zeit zum Neubeleuchten</translation>
  </message>
  <message>
   <source>Time to bake</source>
   <translation>Zeit zum Vorberechnen</translation>
  </message>
  <message>
   <source>refining the reference</source>
   <translation>Referenz wird verfeinert</translation>
  </message>
  <message>
   <source>no pixel is covered completely: the image is too small, or the model is out of sight</source>
   <translation>kein Pixel ist vollständig bedeckt: das Bild ist zu klein, oder das Modell liegt außerhalb</translation>
  </message>
  <message>
   <source>a sweep compares modes of which some show no light near the model; leave near_lamps out</source>
   <translation>eine Messreihe vergleicht Modi, von denen einige kein Licht nah am Modell zeigen; near_lamps weglassen</translation>
  </message>
  <message>
   <source>a small image of %1</source>
   <translation>ein kleines Bild von %1</translation>
  </message>
  <message>
   <source>its image</source>
   <translation>sein Bild</translation>
  </message>
  <message>
   <source>the time was over</source>
   <translation>die Zeit war um</translation>
  </message>
  <message>
   <source>%1 settings measured</source>
   <translation>%1 Einstellungen gemessen</translation>
  </message>
  <message>
   <source>Time of a frame / ms</source>
   <translation>Zeit eines Bildes / ms</translation>
  </message>
  <message>
   <source>Time to relight / ms</source>
   <translation>Zeit zum Neubeleuchten / ms</translation>
  </message>
  <message>
   <source>Time to bake / s</source>
   <translation>Zeit zum Vorberechnen / s</translation>
  </message>
  <message>
   <source>paths %1</source>
   <translation>Pfade %1</translation>
  </message>
  <message>
   <source>lights %1</source>
   <translation>Lichter %1</translation>
  </message>
  <message>
   <source>terms %1</source>
   <translation>Terme %1</translation>
  </message>
  <message>
   <source>kept %1</source>
   <translation>behalten %1</translation>
  </message>
  <message>
   <source>%1 (extrapolated)</source>
   <translation>%1 (extrapoliert)</translation>
  </message>
  <message>
   <source>on the CPU</source>
   <translation>auf der CPU</translation>
  </message>
  <message>
   <source>by %1</source>
   <translation>von %1</translation>
  </message>
  <message>
   <source>Bars: 95 %. Errors against %1 paths for each pixel; frames drawn %2.</source>
   <translation>Balken: 95 %. Fehler gegenüber %1 Pfaden je Pixel; Bilder gezeichnet %2.</translation>
  </message>
  <message>
   <source> %1 settings have no such cost.</source>
   <translation> %1 Einstellungen haben solche Kosten nicht.</translation>
  </message>
  <message>
   <source>
%1 settings were not measured but extrapolated.</source>
   <translation>
%1 Einstellungen wurden nicht gemessen, sondern extrapoliert.</translation>
  </message>
  <message>
   <source>Error, relative RMSE / %</source>
   <translation>Fehler, relativer RMSE / %</translation>
  </message>
  <message>
   <source>1 frame</source>
   <translation>1 Bild</translation>
  </message>
  <message>
   <source>%1 frames</source>
   <translation>%1 Bildern</translation>
  </message>
  <message>
   <source>
Break-even: with their bake, %1 take less time than the reference at equal error after %2.</source>
   <translation>
Amortisation: mit ihrer Vorberechnung braucht %1 bei gleichem Fehler weniger Zeit als die Referenz nach %2.</translation>
  </message>
  <message>
   <source>drawing plots</source>
   <translation>Diagramme werden gezeichnet</translation>
  </message>
 </context>
 <context>
  <name>engine/bundle</name>
  <message>
   <source>the kept tiles</source>
   <translation>die behaltenen Kacheln</translation>
  </message>
  <message>
   <source>the material is larger than the %1 GiB of a bundle</source>
   <translation>das Material ist größer als die %1 GiB eines Pakets</translation>
  </message>
  <message>
   <source>Reduce the resolution</source>
   <translation>Die Auflösung verringern</translation>
  </message>
  <message>
   <source>it exists and cannot be replaced, because %1</source>
   <translation>es existiert und lässt sich nicht ersetzen, weil %1</translation>
  </message>
  <message>
   <source>holds a material that cannot be: %1</source>
   <translation>enthält ein unmögliches Material: %1</translation>
  </message>
  <message>
   <source>%1 is not in the manifest.</source>
   <translation>%1 steht nicht im Manifest.</translation>
  </message>
  <message>
   <source>%1 contradicts the manifest</source>
   <translation>%1 widerspricht dem Manifest</translation>
  </message>
  <message>
   <source>the material has neither a shading map nor a power law, a directional map or PBR maps</source>
   <translation>das Material hat weder Schattierungskarte noch Potenzgesetz, Richtungskarte oder PBR-Karten</translation>
  </message>
  <message>
   <source>PBR maps replace what comes from photographs: a material has one of them</source>
   <translation>PBR-Karten ersetzen, was aus Fotos kommt: ein Material hat eines von beiden</translation>
  </message>
  <message>
   <source>%1 has values that are negative or not finite</source>
   <translation>%1 hat negative oder nicht endliche Werte</translation>
  </message>
  <message>
   <source>8-bit sRGB levels per level of a plane</source>
   <translation>8-Bit-Stufen in sRGB für jede Stufe einer Ebene</translation>
  </message>
  <message>
   <source>%1 has lights that cannot be interpolated</source>
   <translation>%1 hat Lichter, die sich nicht interpolieren lassen</translation>
  </message>
  <message>
   <source>%1 is not what %2 gives.</source>
   <translation>%1 ist nicht, was %2 ergibt.</translation>
  </message>
  <message>
   <source>%1 has other numbers than the manifest says</source>
   <translation>%1 hat andere Zahlen, als das Manifest sagt</translation>
  </message>
  <message>
   <source>%1 has lights that are not unit vectors</source>
   <translation>%1 hat Lichter, die keine Einheitsvektoren sind</translation>
  </message>
  <message>
   <source>lightarc bundle view opens a newly made page</source>
   <translation>lightarc bundle view öffnet eine neu erzeugte Seite</translation>
  </message>
  <message>
   <source>lightarc export --to shaders writes a new one</source>
   <translation>lightarc export --to shaders schreibt einen neu</translation>
  </message>
  <message>
   <source>the BRDF that counts is the one in the manifest</source>
   <translation>es gilt die BRDF im Manifest</translation>
  </message>
  <message>
   <source>%1 is not what this program makes of the material; export the bundle again.</source>
   <translation>%1 ist nicht, was dieses Programm aus dem Material macht; das Paket neu exportieren.</translation>
  </message>
  <message>
   <source>version %1</source>
   <translation>Version %1</translation>
  </message>
  <message>
   <source>no version that is named</source>
   <translation>keiner genannten Version</translation>
  </message>
  <message>
   <source>another build of version %1</source>
   <translation>einer anderen Fassung der Version %1</translation>
  </message>
  <message>
   <source>was written by %1, and this one cannot check whether somebody changed it</source>
   <translation>wurde von %1 geschrieben, und dieses Programm kann nicht erkennen, ob jemand es geändert hat</translation>
  </message>
  <message>
   <source>1, data without a colour space</source>
   <translation>1, Daten ohne Farbraum</translation>
  </message>
  <message>
   <source>%1 does not cover whole tiles of %2 texels</source>
   <translation>%1 deckt keine ganzen Kacheln von %2 Texeln</translation>
  </message>
  <message>
   <source>%1 would have %2 bytes of pixels</source>
   <translation>%1 hätte %2 Bytes an Pixeln</translation>
  </message>
  <message>
   <source>Use a smaller bundle</source>
   <translation>Ein kleineres Paket verwenden</translation>
  </message>
  <message>
   <source>%1 needs %2 of memory, and %3 are free</source>
   <translation>%1 braucht %2 Speicher, und %3 sind frei</translation>
  </message>
  <message>
   <source>Open it on a machine with more, or make the material smaller</source>
   <translation>Auf einem Rechner mit mehr Speicher öffnen oder das Material verkleinern</translation>
  </message>
  <message>
   <source>%1 is not as it was written</source>
   <translation>%1 ist nicht, wie es geschrieben wurde</translation>
  </message>
  <message>
   <source>Ask for the bundle again</source>
   <translation>Das Paket noch einmal anfordern</translation>
  </message>
  <message>
   <source>%1 is not in the manifest</source>
   <translation>%1 steht nicht im Manifest</translation>
  </message>
  <message>
   <source>has %1 x %2 pixels where the manifest says %3 x %4</source>
   <translation>hat %1 x %2 Pixel, wo das Manifest %3 x %4 sagt</translation>
  </message>
  <message>
   <source>has other channels than the %1 that the manifest implies</source>
   <translation>hat andere Kanäle als die %1, die das Manifest verlangt</translation>
  </message>
  <message>
   <source>has a channel %1 that is not of %2-bit floats at full resolution</source>
   <translation>hat einen Kanal %1, der nicht aus %2-Bit-Gleitkommazahlen in voller Auflösung besteht</translation>
  </message>
  <message>
   <source>is not a PNG</source>
   <translation>ist kein PNG</translation>
  </message>
  <message>
   <source>a grey</source>
   <translation>ein graues</translation>
  </message>
  <message>
   <source>an RGB</source>
   <translation>ein RGB-</translation>
  </message>
  <message>
   <source>is not %1 image of %2 x %3 pixels with %4 bits each</source>
   <translation>ist nicht %1 Bild von %2 x %3 Pixeln mit je %4 Bit</translation>
  </message>
  <message>
   <source>Brightest light</source>
   <translation>Hellstes Licht</translation>
  </message>
  <message>
   <source>the page shows the compressed pair or planes, which this material does not have</source>
   <translation>die Seite zeigt das komprimierte Paar oder Ebenen, die dieses Material nicht hat</translation>
  </message>
  <message>
   <source> along the arc</source>
   <translation> längs des Bogens</translation>
  </message>
  <message>
   <source>Normals%1</source>
   <translation>Normalen%1</translation>
  </message>
  <message>
   <source>Relief</source>
   <translation>Relief</translation>
  </message>
  <message>
   <source>Enhanced highlights</source>
   <translation>Verstärkte Glanzlichter</translation>
  </message>
  <message>
   <source>%1 has other maps than those of a BRDF</source>
   <translation>%1 hat andere Karten als die einer BRDF</translation>
  </message>
  <message>
   <source>states layers that there are not (%1)</source>
   <translation>nennt Schichten, die es nicht gibt (%1)</translation>
  </message>
  <message>
   <source>states layers of a model that has none</source>
   <translation>nennt Schichten eines Modells, das keine hat</translation>
  </message>
  <message>
   <source>The BRDF is not a fit.</source>
   <translation>Die BRDF ist keine Anpassung.</translation>
  </message>
  <message>
   <source>the measured BRDF %1</source>
   <translation>der gemessenen BRDF %1</translation>
  </message>
  <message>
   <source>The BRDF is a fit of %1, with a relative RMSE of f cos(theta_i) of %2.</source>
   <translation>Die BRDF ist eine Anpassung von %1 mit einem relativen RMSE von f cos(theta_i) von %2.</translation>
  </message>
  <message>
   <source>image of the page</source>
   <translation>Bild der Seite</translation>
  </message>
 </context>
 <context>
  <name>engine/exchange</name>
  <message>
   <source>behind Shader to RGB</source>
   <translation>hinter Shader to RGB</translation>
  </message>
  <message>
   <source>writing the power law</source>
   <translation>Potenzgesetz wird geschrieben</translation>
  </message>
  <message>
   <source>the script</source>
   <translation>das Skript</translation>
  </message>
  <message>
   <source>the material has no power law, so there is no material behind Shader to RGB</source>
   <translation>das Material hat kein Potenzgesetz, also gibt es kein Material hinter Shader to RGB</translation>
  </message>
  <message>
   <source>tiles that keep their slices are shown by the power law</source>
   <translation>Kacheln, die ihre Schichten behalten, werden durch das Potenzgesetz gezeigt</translation>
  </message>
  <message>
   <source>making the .blend</source>
   <translation>.blend wird erzeugt</translation>
  </message>
  <message>
   <source>Blender imports %1.glb, or opens it where the desktop opens such files with Blender; the .blend is made by %2.py, opened and run in Blender's workspace Scripting, or by blender --background --python %3.py</source>
   <translation>Blender importiert %1.glb oder öffnet es, wo der Desktop solche Dateien mit Blender öffnet; das .blend erzeugt %2.py, geöffnet und ausgeführt in Blenders Arbeitsbereich Scripting oder durch blender --background --python %3.py</translation>
  </message>
  <message>
   <source>evaluating the BRDF</source>
   <translation>BRDF wird ausgewertet</translation>
  </message>
  <message>
   <source>writing RGL's table</source>
   <translation>RGL-Tabelle wird geschrieben</translation>
  </message>
  <message>
   <source>the BRDF is anisotropic: MERL's table is its average over azimuth, and no .bsdf is written</source>
   <translation>die BRDF ist anisotrop: MERLs Tabelle ist ihr Mittel über den Azimut, und kein .bsdf wird geschrieben</translation>
  </message>
  <message>
   <source>%1 away (relative RMSE of f cos)</source>
   <translation>%1 entfernt (relativer RMSE von f cos)</translation>
  </message>
  <message>
   <source>%1.mtlx leaves out the rotation of the anisotropy, %2</source>
   <translation>%1.mtlx lässt die Drehung der Anisotropie weg, %2</translation>
  </message>
  <message>
   <source>%1.mtlx is the nearest metallic-roughness, %2</source>
   <translation>%1.mtlx ist die nächste metallisch-raue Form, %2</translation>
  </message>
  <message>
   <source>Made by Lightarc %1. Values at %2 pairs of directions, exact there to nine digits.</source>
   <translation>Erzeugt von Lightarc %1. Werte an %2 Richtungspaaren, dort auf neun Stellen exakt.</translation>
  </message>
  <message>
   <source>%1 alone: the texels of the material are not in these files.</source>
   <translation>nur %1: die Texel des Materials sind nicht in diesen Dateien.</translation>
  </message>
  <message>
   <source>a relative RMSE of f cos of %1</source>
   <translation>ein relativer RMSE von f cos von %1</translation>
  </message>
  <message>
   <source>exact to the rounding of its numbers</source>
   <translation>exakt bis auf die Rundung seiner Zahlen</translation>
  </message>
  <message>
   <source>%1: %2 What lies between them is the reader's.</source>
   <translation>%1: %2 Was dazwischen liegt, bestimmt das lesende Programm.</translation>
  </message>
  <message>
   <source>the table</source>
   <translation>die Tabelle</translation>
  </message>
  <message>
   <source>Lightarc %1. A table with a relative RMSE of f cos of %2.</source>
   <translation>Lightarc %1. Eine Tabelle mit einem relativen RMSE von f cos von %2.</translation>
  </message>
  <message>
   <source>Made by Lightarc %1. A fit with a relative RMSE of f cos of %2.</source>
   <translation>Erzeugt von Lightarc %1. Eine Anpassung mit einem relativen RMSE von f cos von %2.</translation>
  </message>
  <message>
   <source>Made by Lightarc %1.</source>
   <translation>Erzeugt von Lightarc %1.</translation>
  </message>
  <message>
   <source>a tile of %1 × %2 repeats is not within %3 to %4</source>
   <translation>eine Kachel aus %1 × %2 Wiederholungen liegt nicht zwischen %3 und %4</translation>
  </message>
  <message>
   <source>at most %1 repeats fit</source>
   <translation>höchstens %1 Wiederholungen passen</translation>
  </message>
  <message>
   <source>make the material smaller first</source>
   <translation>das Material zuerst verkleinern</translation>
  </message>
  <message>
   <source>a tile of %1 × %2 texels is too large; %3</source>
   <translation>eine Kachel von %1 × %2 Texeln ist zu groß; %3</translation>
  </message>
  <message>
   <source>an object with a mask does not repeat; cut a tile out of it (lightarc shade --part)</source>
   <translation>ein Objekt mit Maske wiederholt sich nicht; eine Kachel herausschneiden</translation>
  </message>
  <message>
   <source>a power law of which some tiles keep their slices cannot be enlarged; build it without them</source>
   <translation>ein Potenzgesetz, bei dem einige Kacheln ihre Schichten behalten, lässt sich nicht vergrößern; ohne diese erzeugen</translation>
  </message>
  <message>
   <source>enlarging the tile</source>
   <translation>Kachel wird vergrößert</translation>
  </message>
  <message>
   <source>PBR textures, named and packed for a program</source>
   <translation>PBR-Texturen, für ein Programm benannt und gepackt</translation>
  </message>
  <message>
   <source>MaterialX: OpenPBR and glTF PBR surfaces</source>
   <translation>MaterialX: OpenPBR- und glTF-PBR-Oberflächen</translation>
  </message>
  <message>
   <source>glTF: a preview sphere with the material, as .glb</source>
   <translation>glTF: eine Vorschaukugel mit dem Material, als .glb</translation>
  </message>
  <message>
   <source>USD: a preview sphere with UsdPreviewSurface, as .usdz</source>
   <translation>USD: eine Vorschaukugel mit UsdPreviewSurface, als .usdz</translation>
  </message>
  <message>
   <source>Blender: a .blend where Blender's module is installed, else a .glb and a script</source>
   <translation>Blender: ein .blend, wo Blenders Modul installiert ist, sonst ein .glb und ein Skript</translation>
  </message>
  <message>
   <source>GLSL, HLSL and OSL that evaluate the material itself</source>
   <translation>GLSL, HLSL und OSL, die das Material selbst auswerten</translation>
  </message>
  <message>
   <source>A page for any browser, and one for strict sites</source>
   <translation>Eine Seite für jeden Browser und eine für strenge Websites</translation>
  </message>
  <message>
   <source>RTI: .ptm, .rti and a tree for web viewers</source>
   <translation>RTI: .ptm, .rti und ein Baum für Web-Betrachter</translation>
  </message>
  <message>
   <source>BRDF tables (CSV, ALTA, MERL, RGL) and the nearest model</source>
   <translation>BRDF-Tabellen (CSV, ALTA, MERL, RGL) und das nächste Modell</translation>
  </message>
  <message>
   <source>packing %1</source>
   <translation>%1 wird gepackt</translation>
  </message>
  <message>
   <source>an error of %1 is not a number from 0 upwards</source>
   <translation>ein Fehler von %1 ist keine Zahl ab 0</translation>
  </message>
  <message>
   <source>%1 chooses the target: give %2 alone, or targets by name</source>
   <translation>%1 wählt das Ziel: %2 allein angeben, oder Ziele mit Namen</translation>
  </message>
  <message>
   <source>unknown target %1; choose from %2, or %3 alone</source>
   <translation>unbekanntes Ziel %1; möglich: %2, oder %3 allein</translation>
  </message>
  <message>
   <source>%1 holds a material from photographs; PBR maps leave as the other targets</source>
   <translation>%1 enthält ein Material aus Fotos; PBR-Karten gehen als die anderen Ziele hinaus</translation>
  </message>
  <message>
   <source>an RTI file needs light from several sides: give the stack of a dome</source>
   <translation>eine RTI-Datei braucht Licht von mehreren Seiten: den Stapel einer Kuppel verwenden</translation>
  </message>
  <message>
   <source>no representation keeps an error of %1; this one has the least</source>
   <translation>keine Darstellung hält einen Fehler von %1 ein; diese hat den kleinsten</translation>
  </message>
  <message>
   <source>where a pixel covers many texels, other programs show highlights up to %1 times too bright: they average normals, and these files cannot hold how far they differ; there, take maps of fewer texels and more roughness</source>
   <translation>wo ein Pixel viele Texel bedeckt, zeigen andere Programme Glanzlichter bis zu %1-mal zu hell: sie mitteln Normalen, und diese Dateien können deren Streuung nicht enthalten; dort Karten mit weniger Texeln und mehr Rauheit verwenden</translation>
  </message>
  <message>
   <source>the material was cut to a tile, so that it is not compared with the photographs</source>
   <translation>das Material wurde zu einer Kachel geschnitten und wird deshalb nicht mit den Fotos verglichen</translation>
  </message>
  <message>
   <source>writing images</source>
   <translation>Bilder werden geschrieben</translation>
  </message>
  <message>
   <source>writing the preview sphere</source>
   <translation>Vorschaukugel wird geschrieben</translation>
  </message>
  <message>
   <source>clear coat</source>
   <translation>Klarlack</translation>
  </message>
  <message>
   <source>thin film</source>
   <translation>dünner Film</translation>
  </message>
  <message>
   <source>colour of highlights</source>
   <translation>Farbe der Glanzlichter</translation>
  </message>
  <message>
   <source>diffuse roughness</source>
   <translation>diffuse Rauheit</translation>
  </message>
  <message>
   <source>the clear coat of glTF is written as OpenPBR's coat, which is another lobe</source>
   <translation>der Klarlack von glTF wird als Lack von OpenPBR geschrieben, was eine andere Keule ist</translation>
  </message>
  <message>
   <source>the sheen of glTF is written as OpenPBR's fuzz, which is another lobe</source>
   <translation>der Sheen von glTF wird als Flaum von OpenPBR geschrieben, was eine andere Keule ist</translation>
  </message>
  <message>
   <source>fuzz is written as sheen, which is another lobe</source>
   <translation>Flaum wird als Sheen geschrieben, was eine andere Keule ist</translation>
  </message>
  <message>
   <source>the coat has no colour here, and the index 1.5</source>
   <translation>der Lack hat hier keine Farbe und die Brechzahl 1,5</translation>
  </message>
  <message>
   <source>the coat is written as a clear coat, which is another lobe</source>
   <translation>der Lack wird als Klarlack geschrieben, was eine andere Keule ist</translation>
  </message>
  <message>
   <source>diffuse roughness and weights of the base are not written</source>
   <translation>diffuse Rauheit und Gewichte der Grundschicht fehlen</translation>
  </message>
  <message>
   <source>layers are not written: %1</source>
   <translation>Schichten fehlen: %1</translation>
  </message>
  <message>
   <source>Reference, %1</source>
   <translation>Referenz, %1</translation>
  </message>
  <message>
   <source>Comparing under %1</source>
   <translation>Vergleich unter %1</translation>
  </message>
  <message>
   <source>It shows no image of the surface.</source>
   <translation>Es zeigt kein Bild der Oberfläche.</translation>
  </message>
  <message>
   <source>relative RMSE undefined, as the material is black</source>
   <translation>relativer RMSE nicht definiert, da das Material schwarz ist</translation>
  </message>
  <message>
   <source>relative RMSE %1</source>
   <translation>relativer RMSE %1</translation>
  </message>
  <message>
   <source>Error of what these files show, against the material under %1: %2</source>
   <translation>Fehler dessen, was diese Dateien zeigen, gegenüber dem Material unter %1: %2</translation>
  </message>
  <message>
   <source>; against the photographs: relative RMSE %1</source>
   <translation>; gegenüber den Fotos: relativer RMSE %1</translation>
  </message>
  <message>
   <source>these files show no image of the surface, so that there is nothing to compare</source>
   <translation>diese Dateien zeigen kein Bild der Oberfläche, also gibt es nichts zu vergleichen</translation>
  </message>
  <message>
   <source>the photographs</source>
   <translation>die Fotos</translation>
  </message>
  <message>
   <source>these files show light where the material is black (FLIP %1 under %2)</source>
   <translation>diese Dateien zeigen Licht, wo das Material schwarz ist (FLIP %1 unter %2)</translation>
  </message>
  <message>
   <source>what these files show is %1 away from the material (relative RMSE under %2)</source>
   <translation>was diese Dateien zeigen, ist %1 vom Material entfernt (relativer RMSE unter %2)</translation>
  </message>
  <message>
   <source>these are the errors of the power law; the slices next to it are %1 away in GLSL and HLSL</source>
   <translation>dies sind die Fehler des Potenzgesetzes; die Schichten daneben sind in GLSL und HLSL %1 entfernt</translation>
  </message>
  <message>
   <source>the power law without the tiles that keep their slices is %1 away in HLSL and OSL</source>
   <translation>das Potenzgesetz ohne die Kacheln, die ihre Schichten behalten, ist in HLSL und OSL %1 entfernt</translation>
  </message>
  <message>
   <source>the power law behind Shader to RGB is %1 away from the material</source>
   <translation>das Potenzgesetz hinter Shader to RGB ist %1 vom Material entfernt</translation>
  </message>
  <message>
   <source>writing the document</source>
   <translation>Dokument wird geschrieben</translation>
  </message>
  <message>
   <source>the document</source>
   <translation>das Dokument</translation>
  </message>
  <message>
   <source>the OpenPBR surface has no ambient occlusion; the glTF PBR surface has it</source>
   <translation>die OpenPBR-Oberfläche hat keine Umgebungsverdeckung; die glTF-PBR-Oberfläche hat sie</translation>
  </message>
  <message>
   <source>the glTF PBR surface: %1</source>
   <translation>die glTF-PBR-Oberfläche: %1</translation>
  </message>
  <message>
   <source>the OpenPBR surface: %1</source>
   <translation>die OpenPBR-Oberfläche: %1</translation>
  </message>
  <message>
   <source>the OpenPBR surface: the rotation of the anisotropy is not written</source>
   <translation>die OpenPBR-Oberfläche: die Drehung der Anisotropie fehlt</translation>
  </message>
  <message>
   <source>Made by Lightarc %1. %2</source>
   <translation>Erzeugt von Lightarc %1. %2</translation>
  </message>
  <message>
   <source>hexagonal cells of MaterialX are blended by brightness, not by their histogram as Lightarc draws them</source>
   <translation>Sechseckzellen von MaterialX werden nach Helligkeit gemischt, nicht nach ihrem Histogramm, wie Lightarc sie zeichnet</translation>
  </message>
  <message>
   <source>comparing directions</source>
   <translation>Richtungen werden verglichen</translation>
  </message>
  <message>
   <source>choosing metallic</source>
   <translation>Metallanteil wird gewählt</translation>
  </message>
  <message>
   <source>finding the nearest maps</source>
   <translation>nächste Karten werden gesucht</translation>
  </message>
  <message>
   <source>the material has neither a shading map nor a power law</source>
   <translation>das Material hat weder eine Schattierungskarte noch ein Potenzgesetz</translation>
  </message>
  <message>
   <source>%1 in the archive is not read: its textures are taken by their names; unpack it to read it</source>
   <translation>%1 im Archiv wird nicht gelesen: seine Texturen werden nach Namen genommen; zum Lesen entpacken</translation>
  </message>
  <message>
   <source>scene-linear rec.709-srgb</source>
   <translation>szenenlineares Rec.709-sRGB</translation>
  </message>
  <message>
   <source>Copy the textures next to the document, or name their folder with --search</source>
   <translation>Die Texturen neben das Dokument kopieren oder ihren Ordner mit --search angeben</translation>
  </message>
  <message>
   <source>Copy the textures next to it, or name their folder with --search</source>
   <translation>Die Texturen danebenkopieren oder ihren Ordner mit --search angeben</translation>
  </message>
  <message>
   <source>Export it as .glb, or name the folder of its images with --search</source>
   <translation>Als .glb exportieren oder den Ordner seiner Bilder mit --search angeben</translation>
  </message>
  <message>
   <source>Copy the textures next to it, name their folder with --search, or export it as .usdz</source>
   <translation>Die Texturen danebenkopieren, ihren Ordner mit --search angeben oder als .usdz exportieren</translation>
  </message>
  <message>
   <source>has no material</source>
   <translation>hat kein Material</translation>
  </message>
  <message>
   <source>Export it with its materials</source>
   <translation>Mit seinen Materialien exportieren</translation>
  </message>
  <message>
   <source>Choose one of %1</source>
   <translation>Eines von %1 wählen</translation>
  </message>
  <message>
   <source>of %1 materials, %2 is taken; %3#NAME chooses another one</source>
   <translation>von %1 Materialien wird %2 genommen; %3#NAME wählt ein anderes</translation>
  </message>
  <message>
   <source>Copy that as well, or name its folder with --search</source>
   <translation>Diese mitkopieren oder ihren Ordner mit --search angeben</translation>
  </message>
  <message>
   <source>colours of vertices are passed over on other models</source>
   <translation>Farben von Eckpunkten entfallen auf anderen Modellen</translation>
  </message>
  <message>
   <source>image %1</source>
   <translation>Bild %1</translation>
  </message>
  <message>
   <source>names bytes of an image that it does not have</source>
   <translation>nennt Bytes eines Bildes, die es nicht hat</translation>
  </message>
  <message>
   <source>Put the textures of one material into a folder, named like rock_base_color.png and rock_normal.png</source>
   <translation>Die Texturen eines Materials in einen Ordner legen, benannt wie rock_base_color.png und rock_normal.png</translation>
  </message>
  <message>
   <source>holds no base colour among its images</source>
   <translation>enthält unter seinen Bildern keine Grundfarbe</translation>
  </message>
  <message>
   <source>no texture says these, which are taken as %1</source>
   <translation>diese gibt keine Textur an; angenommen wird %1</translation>
  </message>
  <message>
   <source>%1%2: named for no map that is drawn, and passed over</source>
   <translation>%1%2: für keine gezeichnete Karte benannt, entfällt</translation>
  </message>
  <message>
   <source>the record</source>
   <translation>die Aufzeichnung</translation>
  </message>
  <message>
   <source>%1 and %2 more</source>
   <translation>%1 und %2 weitere</translation>
  </message>
  <message>
   <source>holds a set of UDIM tiles (%1), of which one is read at a time</source>
   <translation>enthält einen Satz von UDIM-Kacheln (%1), von denen nur eine auf einmal gelesen wird</translation>
  </message>
  <message>
   <source>Put the textures of one tile into a folder of its own</source>
   <translation>Die Texturen einer Kachel in einen eigenen Ordner legen</translation>
  </message>
  <message>
   <source>holds several images for %1 (%2)</source>
   <translation>enthält mehrere Bilder für %1 (%2)</translation>
  </message>
  <message>
   <source>textures have texture coordinates of their own (texCoord or a transform), of which those of the first are taken for all</source>
   <translation>Texturen haben eigene Texturkoordinaten (texCoord oder eine Transformation); die der ersten gelten für alle</translation>
  </message>
  <message>
   <source>the texture coordinates that its textures ask for are those of its own model alone</source>
   <translation>die von den Texturen verlangten Texturkoordinaten hat nur das eigene Modell</translation>
  </message>
  <message>
   <source>is to be shown without light; it is drawn as a diffuse surface of its colour</source>
   <translation>soll ohne Licht gezeigt werden; es wird als diffuse Oberfläche seiner Farbe gezeichnet</translation>
  </message>
  <message>
   <source>light that goes through the surface is lost</source>
   <translation>Licht, das durch die Oberfläche geht, entfällt</translation>
  </message>
  <message>
   <source>transmissionTexture is passed over</source>
   <translation>transmissionTexture entfällt</translation>
  </message>
  <message>
   <source>%1 is passed over</source>
   <translation>%1 entfällt</translation>
  </message>
  <message>
   <source>highlights of dielectrics have a colour, which is taken as grey</source>
   <translation>Glanzlichter von Nichtleitern haben eine Farbe, die als Grau gilt</translation>
  </message>
  <message>
   <source>the strength %1 of the occlusion is passed over</source>
   <translation>die Stärke %1 der Verdeckung entfällt</translation>
  </message>
  <message>
   <source>%1 is not drawn</source>
   <translation>%1 wird nicht gezeichnet</translation>
  </message>
  <message>
   <source>has %1 images, which are not read</source>
   <translation>hat %1-Bilder, die nicht gelesen werden</translation>
  </message>
  <message>
   <source>Export it with PNG or JPEG</source>
   <translation>Mit PNG oder JPEG exportieren</translation>
  </message>
  <message>
   <source>has an image without content</source>
   <translation>hat ein Bild ohne Inhalt</translation>
  </message>
  <message>
   <source>names one of its %1 that it does not have</source>
   <translation>nennt eines der %1, das es nicht hat</translation>
  </message>
  <message>
   <source>has an entry of %1 that is none</source>
   <translation>hat einen Eintrag von %1, der keiner ist</translation>
  </message>
  <message>
   <source>has an image within its text that is damaged</source>
   <translation>hat im Text ein beschädigtes Bild</translation>
  </message>
  <message>
   <source>has an impossible %1</source>
   <translation>hat unmöglich: %1</translation>
  </message>
  <message>
   <source>the text</source>
   <translation>der Text</translation>
  </message>
  <message>
   <source>is an incomplete .glb</source>
   <translation>ist ein unvollständiges .glb</translation>
  </message>
  <message>
   <source>is an incomplete .glb, or of another version</source>
   <translation>ist ein unvollständiges .glb oder von anderer Version</translation>
  </message>
  <message>
   <source>its first chunk</source>
   <translation>sein erster Block</translation>
  </message>
  <message>
   <source>is not glTF</source>
   <translation>ist kein glTF</translation>
  </message>
  <message>
   <source>requires the extension %1, which is not known</source>
   <translation>verlangt die unbekannte Erweiterung %1</translation>
  </message>
  <message>
   <source>Export it without that</source>
   <translation>Ohne das exportieren</translation>
  </message>
  <message>
   <source>sheen is drawn as OpenPBR's fuzz</source>
   <translation>Sheen wird als Flaum von OpenPBR gezeichnet</translation>
  </message>
  <message>
   <source>clear coat is drawn as OpenPBR's coat</source>
   <translation>Klarlack wird als Lack von OpenPBR gezeichnet</translation>
  </message>
  <message>
   <source>has no surface that is read</source>
   <translation>hat keine Oberfläche, die gelesen wird</translation>
  </message>
  <message>
   <source>defines entities, which no MaterialX document needs</source>
   <translation>definiert Entitäten, die kein MaterialX-Dokument braucht</translation>
  </message>
  <message>
   <source>is not valid XML (%1)</source>
   <translation>ist kein gültiges XML (%1)</translation>
  </message>
  <message>
   <source>is not a MaterialX document</source>
   <translation>ist kein MaterialX-Dokument</translation>
  </message>
  <message>
   <source>Give a .mtlx file</source>
   <translation>Eine .mtlx-Datei angeben</translation>
  </message>
  <message>
   <source>of %1 surfaces, %2 (%3) is taken</source>
   <translation>von %1 Oberflächen wird %2 (%3) genommen</translation>
  </message>
  <message>
   <source>a constant %1 is passed over</source>
   <translation>die Konstante %1 entfällt</translation>
  </message>
  <message>
   <source>%1 %2 not drawn</source>
   <translation>%1 %2 nicht gezeichnet</translation>
  </message>
  <message>
   <source>light that is scattered below the surface leaves where it came, as from a diffuse one</source>
   <translation>unter der Oberfläche gestreutes Licht tritt dort aus, wo es eintrat, wie bei einer diffusen</translation>
  </message>
  <message>
   <source>%1 is mixed with an image, which is passed over</source>
   <translation>%1 ist mit einem Bild gemischt, das entfällt</translation>
  </message>
  <message>
   <source>the image of %1 is passed over</source>
   <translation>das Bild von %1 entfällt</translation>
  </message>
  <message>
   <source>clear coat is drawn as glTF's</source>
   <translation>Klarlack wird wie der von glTF gezeichnet</translation>
  </message>
  <message>
   <source>the image of %1 is passed over, and %2 taken</source>
   <translation>das Bild von %1 entfällt, genommen wird %2</translation>
  </message>
  <message>
   <source>%1 comes from nodes that are not read, and its default is taken</source>
   <translation>%1 kommt aus Knoten, die nicht gelesen werden; der Vorgabewert gilt</translation>
  </message>
  <message>
   <source>has %1 numbers for %2</source>
   <translation>hat %1 Zahlen für %2</translation>
  </message>
  <message>
   <source>has nodes that lead to each other without end</source>
   <translation>hat Knoten, die endlos aufeinander verweisen</translation>
  </message>
  <message>
   <source>%1 of texture coordinates %2 passed over</source>
   <translation>%1 der Texturkoordinaten %2 nicht berücksichtigt</translation>
  </message>
  <message>
   <source>%1 states no colour space, and is taken as linear Rec.709</source>
   <translation>%1 gibt keinen Farbraum an und gilt als lineares Rec.709</translation>
  </message>
  <message>
   <source>hexagonal tiling</source>
   <translation>Sechseckkachelung</translation>
  </message>
  <message>
   <source>the node %1</source>
   <translation>der Knoten %1</translation>
  </message>
  <message>
   <source>states the colour space %1, which is not known</source>
   <translation>gibt den unbekannten Farbraum %1 an</translation>
  </message>
  <message>
   <source>Save it in lin_rec709, srgb_texture or acescg</source>
   <translation>In lin_rec709, srgb_texture oder acescg speichern</translation>
  </message>
  <message>
   <source>has an impossible value (%1)</source>
   <translation>hat einen unmöglichen Wert (%1)</translation>
  </message>
  <message>
   <source>a clear coat</source>
   <translation>ein Klarlack</translation>
  </message>
  <message>
   <source>a filter of transmitted light</source>
   <translation>ein Filter durchgelassenen Lichts</translation>
  </message>
  <message>
   <source>Export the model with its materials</source>
   <translation>Das Modell mit seinen Materialien exportieren</translation>
  </message>
  <message>
   <source>has an impossible %1 (%2)</source>
   <translation>hat unmöglich: %1 (%2)</translation>
  </message>
  <message>
   <source>%1 of %2 is passed over</source>
   <translation>%1 von %2 entfällt</translation>
  </message>
  <message>
   <source>Kd is 0 and is taken as 1 under map_Kd</source>
   <translation>Kd ist 0 und gilt unter map_Kd als 1</translation>
  </message>
  <message>
   <source>the relief of %1 is not drawn</source>
   <translation>das Relief von %1 wird nicht gezeichnet</translation>
  </message>
  <message>
   <source>is drawn without its materials: it %1</source>
   <translation>wird ohne seine Materialien gezeichnet: es %1</translation>
  </message>
  <message>
   <source>holds textures that are not read (%1)</source>
   <translation>enthält Texturen, die nicht gelesen werden (%1)</translation>
  </message>
  <message>
   <source>is a stack, and no material</source>
   <translation>ist ein Stapel und kein Material</translation>
  </message>
  <message>
   <source>Make one of it with lightarc shade</source>
   <translation>Machen Sie mit lightarc shade eines daraus</translation>
  </message>
  <message>
   <source>holds no textures of a material: by their names these are %1 alone</source>
   <translation>enthält keine Texturen eines Materials: Ihren Namen nach sind es nur %1</translation>
  </message>
  <message>
   <source>Put a base colour and another map there, as rock_color.png, rock_normal.png</source>
   <translation>Legen Sie eine Grundfarbe und eine weitere Karte dorthin, etwa rock_color.png, rock_normal.png</translation>
  </message>
  <message>
   <source>is a texture that is not read (%1)</source>
   <translation>ist eine Textur, die nicht gelesen wird (%1)</translation>
  </message>
  <message>
   <source>is not a PTM or HSH file</source>
   <translation>ist keine PTM- oder HSH-Datei</translation>
  </message>
  <message>
   <source>Give a file that begins with PTM_1.2 or #HSH1.2</source>
   <translation>Eine Datei angeben, die mit PTM_1.2 oder #HSH1.2 beginnt</translation>
  </message>
  <message>
   <source>is no glTF file, of which #NAME chooses a material</source>
   <translation>ist keine glTF-Datei, von der #NAME ein Material wählt</translation>
  </message>
  <message>
   <source>Leave out #%1</source>
   <translation>#%1 weglassen</translation>
  </message>
  <message>
   <source>names no library of materials (mtllib)</source>
   <translation>nennt keine Materialbibliothek (mtllib)</translation>
  </message>
  <message>
   <source>Export it as PTM_FORMAT_RGB, or as HSH</source>
   <translation>Als PTM_FORMAT_RGB oder als HSH exportieren</translation>
  </message>
  <message>
   <source>reading planes</source>
   <translation>Ebenen werden gelesen</translation>
  </message>
  <message>
   <source>looking for the brightest image</source>
   <translation>hellstes Bild wird gesucht</translation>
  </message>
  <message>
   <source>is black under light from every side</source>
   <translation>ist unter Licht von jeder Seite schwarz</translation>
  </message>
  <message>
   <source>Check how it was made</source>
   <translation>Prüfen, wie es entstanden ist</translation>
  </message>
  <message>
   <source>is a PTM of the version %1, which is not read</source>
   <translation>ist ein PTM der Version %1, die nicht gelesen wird</translation>
  </message>
  <message>
   <source>Export it as PTM 1.2</source>
   <translation>Als PTM 1.2 exportieren</translation>
  </message>
  <message>
   <source>is a PTM of the format %1, which is not read</source>
   <translation>ist ein PTM des Formats %1, das nicht gelesen wird</translation>
  </message>
  <message>
   <source>ends after %1 of %2 bytes of its planes</source>
   <translation>endet nach %1 von %2 Bytes seiner Ebenen</translation>
  </message>
  <message>
   <source>is a PTM with planes that are predicted in motion, which are not read</source>
   <translation>ist ein PTM mit bewegungsprädizierten Ebenen, die nicht gelesen werden</translation>
  </message>
  <message>
   <source>says of planes in which order they are made, and not of all</source>
   <translation>nennt die Reihenfolge, in der Ebenen entstehen, nicht von allen</translation>
  </message>
  <message>
   <source>predicts a plane from one that comes after it</source>
   <translation>sagt eine Ebene aus einer voraus, die nach ihr kommt</translation>
  </message>
  <message>
   <source>has corrections of a plane that are cut off</source>
   <translation>hat abgeschnittene Korrekturen einer Ebene</translation>
  </message>
  <message>
   <source>corrects texels that it does not have</source>
   <translation>korrigiert Texel, die es nicht hat</translation>
  </message>
  <message>
   <source>has a plane of more than 8 bits</source>
   <translation>hat eine Ebene mit mehr als 8 Bit</translation>
  </message>
  <message>
   <source>Export its planes as JPEG or PNG with 8 bits</source>
   <translation>Seine Ebenen als JPEG oder PNG mit 8 Bit exportieren</translation>
  </message>
  <message>
   <source>has a plane of %1 texels, and says %2 × %3</source>
   <translation>hat eine Ebene mit %1 Texeln und gibt %2 × %3 an</translation>
  </message>
  <message>
   <source>holds terms of the kind %1, which is not read</source>
   <translation>enthält Terme der Art %1, die nicht gelesen wird</translation>
  </message>
  <message>
   <source>Export it as HSH or PTM</source>
   <translation>Als HSH oder PTM exportieren</translation>
  </message>
  <message>
   <source>has terms that are not a byte for each of R, G and B</source>
   <translation>hat Terme, die nicht ein Byte für je R, G und B sind</translation>
  </message>
  <message>
   <source>Export it as HSH, RGB, 8 bits</source>
   <translation>Als HSH, RGB, 8 Bit exportieren</translation>
  </message>
  <message>
   <source>has %1 terms, which are read up to 16, and of a PTM 6</source>
   <translation>hat %1 Terme; gelesen werden bis zu 16, von einem PTM 6</translation>
  </message>
  <message>
   <source>Export it with fewer</source>
   <translation>Mit weniger exportieren</translation>
  </message>
  <message>
   <source>ends after %1 of %2 bytes of its terms</source>
   <translation>endet nach %1 von %2 Bytes seiner Terme</translation>
  </message>
  <message>
   <source>has more than %1 MiB of numbers</source>
   <translation>hat mehr als %1 MiB an Zahlen</translation>
  </message>
  <message>
   <source>is a tree of the type %1, which is not read</source>
   <translation>ist ein Baum des Typs %1, der nicht gelesen wird</translation>
  </message>
  <message>
   <source>Export it as ptm or hsh</source>
   <translation>Als ptm oder hsh exportieren</translation>
  </message>
  <message>
   <source>is a tree of the type %1 in the colours %2, which are not read</source>
   <translation>ist ein Baum des Typs %1 in den Farben %2, die nicht gelesen werden</translation>
  </message>
  <message>
   <source>Export it in %1</source>
   <translation>In %1 exportieren</translation>
  </message>
  <message>
   <source>has %1 planes, which are read by three, and up to %2</source>
   <translation>hat %1 Ebenen; gelesen werden sie zu dritt und bis zu %2</translation>
  </message>
  <message>
   <source>has %1 terms of the type %2, which has %3</source>
   <translation>hat %1 Terme des Typs %2, der %3 hat</translation>
  </message>
  <message>
   <source>needs plane_%1.jpg or plane_%2.png next to it, which is not there</source>
   <translation>braucht plane_%1.jpg oder plane_%2.png daneben, das nicht da ist</translation>
  </message>
  <message>
   <source>Copy the whole folder, or export its planes as images without tiles</source>
   <translation>Den ganzen Ordner kopieren oder seine Ebenen als Bilder ohne Kacheln exportieren</translation>
  </message>
  <message>
   <source>states no lights above the sample that photographs could have</source>
   <translation>gibt keine Lichter über der Probe an, die Fotos haben könnten</translation>
  </message>
  <message>
   <source>states a range of 0</source>
   <translation>gibt einen Bereich von 0 an</translation>
  </message>
  <message>
   <source>has a header that is cut off</source>
   <translation>hat einen abgeschnittenen Kopf</translation>
  </message>
  <message>
   <source>has %1 in its header in place of a number</source>
   <translation>hat %1 in seinem Kopf anstelle einer Zahl</translation>
  </message>
  <message>
   <source>has more numbers in its header than it needs</source>
   <translation>hat mehr Zahlen in seinem Kopf, als es braucht</translation>
  </message>
  <message>
   <source>states numbers that are not finite, or too large</source>
   <translation>gibt Zahlen an, die nicht endlich oder zu groß sind</translation>
  </message>
  <message>
   <source>does not state %1 numbers as its %2</source>
   <translation>gibt keine %1 Zahlen an für: %2</translation>
  </message>
  <message>
   <source>states %1 in place of a whole number</source>
   <translation>gibt %1 anstelle einer ganzen Zahl an</translation>
  </message>
  <message>
   <source>roughness of the clear coat</source>
   <translation>die Rauheit des Klarlacks</translation>
  </message>
  <message>
   <source>colour of the sheen</source>
   <translation>die Farbe des Sheens</translation>
  </message>
  <message>
   <source>roughness of the sheen</source>
   <translation>die Rauheit des Sheens</translation>
  </message>
  <message>
   <source>making maps</source>
   <translation>Karten werden erzeugt</translation>
  </message>
  <message>
   <source>UDIM tiles are read as one texture of %1 × %2 tiles, %3 texels each at most</source>
   <translation>UDIM-Kacheln werden als eine Textur von %1 × %2 Kacheln gelesen, von je höchstens %3 Texeln</translation>
  </message>
  <message>
   <source>the %1 varies over its texture, %2 to %3; its mean %4 is drawn</source>
   <translation>%1 variiert über die Textur, %2 bis %3; gezeichnet wird das Mittel %4</translation>
  </message>
  <message>
   <source>where a pixel covers normals that differ, the sheen is that of their mean</source>
   <translation>wo ein Pixel verschiedene Normalen deckt, ist der Sheen der ihres Mittels</translation>
  </message>
  <message>
   <source>%1: another size than %2 × %3 texels, brought to it</source>
   <translation>%1: andere Größe als %2 × %3 Texel, darauf gebracht</translation>
  </message>
  <message>
   <source>%1 × %2 texels are taken at %3 × %4, the most that is kept</source>
   <translation>%1 × %2 Texel werden mit %3 × %4 genommen, dem Höchsten, was behalten wird</translation>
  </message>
  <message>
   <source>base colour</source>
   <translation>Grundfarbe</translation>
  </message>
  <message>
   <source>%1 is outside 0 … 1 in %2 of the texels, and clamped</source>
   <translation>%1 liegt in %2 der Texel außerhalb von 0 … 1 und wird begrenzt</translation>
  </message>
  <message>
   <source>up (OpenGL)</source>
   <translation>nach oben (OpenGL)</translation>
  </message>
  <message>
   <source>down (DirectX)</source>
   <translation>nach unten (DirectX)</translation>
  </message>
  <message>
   <source>by its slopes</source>
   <translation>den Steigungen nach</translation>
  </message>
  <message>
   <source>because nothing says otherwise</source>
   <translation>weil nichts anderes angegeben ist</translation>
  </message>
  <message>
   <source>y of the normals is taken to point %1, %2</source>
   <translation>y der Normalen zeigt %1, %2</translation>
  </message>
  <message>
   <source>the normals are called %1, but their slopes look like those of %2</source>
   <translation>die Normalen heißen %1, aber ihre Steigungen sehen aus wie die von %2</translation>
  </message>
  <message>
   <source>holds no %1</source>
   <translation>enthält kein %1</translation>
  </message>
  <message>
   <source>holds several of %1 (%2)</source>
   <translation>enthält mehrere von %1 (%2)</translation>
  </message>
  <message>
   <source>the surface of %1 is not read (%2), and drawn white</source>
   <translation>die Oberfläche von %1 wird nicht gelesen (%2) und weiß gezeichnet</translation>
  </message>
  <message>
   <source>textures have texture coordinates of their own, of which those of the first are taken</source>
   <translation>Texturen haben eigene Texturkoordinaten; die der ersten gelten</translation>
  </message>
  <message>
   <source>has a material of more than %1 shaders</source>
   <translation>hat ein Material mit mehr als %1 Shadern</translation>
  </message>
  <message>
   <source>scale and bias of the texture of %1 are passed over</source>
   <translation>Skalierung und Versatz der Textur von %1 entfallen</translation>
  </message>
  <message>
   <source>textures repeat, where %1 is stated</source>
   <translation>Texturen wiederholen sich, wo %1 angegeben ist</translation>
  </message>
  <message>
   <source>has no image %1</source>
   <translation>hat kein Bild %1</translation>
  </message>
  <message>
   <source>is a damaged package</source>
   <translation>ist ein beschädigtes Paket</translation>
  </message>
  <message>
   <source>fitting polynomials</source>
   <translation>Polynome werden angepasst</translation>
  </message>
  <message>
   <source>fitting harmonics</source>
   <translation>Kugelfunktionen werden angepasst</translation>
  </message>
  <message>
   <source>relighting each file</source>
   <translation>jede Datei wird neu beleuchtet</translation>
  </message>
  <message>
   <source>relative RMSE of the files against the images that they were fitted to: %1</source>
   <translation>relativer RMSE der Dateien gegenüber den Bildern, an die sie angepasst wurden: %1</translation>
  </message>
  <message>
   <source>%1 (These errors are those of %2.rti.)</source>
   <translation>%1 (Das sind die Fehler von %2.rti.)</translation>
  </message>
  <message>
   <source>%1
%2%3.
The header of a PTM has no place for this.
</source>
   <translation>%1
%2%3.
Der Kopf eines PTM hat dafür keinen Platz.
</translation>
  </message>
  <message>
   <source>RTI files show one viewer, straight above</source>
   <translation>RTI-Dateien zeigen einen Betrachter, senkrecht darüber</translation>
  </message>
  <message>
   <source>the errors above are those of %1.rti; %2</source>
   <translation>die Fehler oben sind die von %1.rti; %2</translation>
  </message>
  <message>
   <source>fitting terms</source>
   <translation>Terme werden angepasst</translation>
  </message>
  <message>
   <source>power law alone</source>
   <translation>nur Potenzgesetz</translation>
  </message>
  <message>
   <source>shaders look up a map, and this material has none</source>
   <translation>Shader tasten eine Karte ab, und dieses Material hat keine</translation>
  </message>
  <message>
   <source>writing shaders</source>
   <translation>Shader werden geschrieben</translation>
  </message>
  <message>
   <source>tiles that keep their slices are sampled by the GLSL alone, and shown by the power law else</source>
   <translation>Kacheln, die ihre Schichten behalten, tastet nur das GLSL ab; sonst zeigt sie das Potenzgesetz</translation>
  </message>
  <message>
   <source>the material has no power law, which the OSL looks up; GLSL and HLSL look its slices up</source>
   <translation>das Material hat kein Potenzgesetz, das das OSL abtastet; GLSL und HLSL tasten seine Schichten ab</translation>
  </message>
  <message>
   <source>a width of %1 mm is not within %2 to %3 mm</source>
   <translation>eine Breite von %1 mm liegt nicht zwischen %2 und %3 mm</translation>
  </message>
  <message>
   <source>the BRDF is a fit of the measured one, %1 away (relative RMSE of f cos)</source>
   <translation>die BRDF ist eine Anpassung der gemessenen, %1 entfernt (relativer RMSE von f cos)</translation>
  </message>
  <message>
   <source>Blender (.blend)</source>
   <translation>Blender (.blend)</translation>
  </message>
  <message>
   <source>Two materials, PBR and the power law, in an asset library that Blender opens</source>
   <translation>Zwei Materialien, PBR und das Potenzgesetz, in einer Asset-Bibliothek, die Blender öffnet</translation>
  </message>
  <message>
   <source>Blender (.glb and script)</source>
   <translation>Blender (.glb und Skript)</translation>
  </message>
  <message>
   <source>A .glb that Blender opens, and a script with which Blender makes the .blend; Blender's module is not here</source>
   <translation>Ein .glb, das Blender öffnet, und ein Skript, mit dem Blender das .blend anlegt; Blenders Modul fehlt hier</translation>
  </message>
  <message>
   <source>Base colour, normal, roughness and the like, named and packed for a program</source>
   <translation>Grundfarbe, Normale, Rauheit und Ähnliches, für ein Programm benannt und gepackt</translation>
  </message>
  <message>
   <source>OpenPBR and glTF PBR surfaces as .mtlx</source>
   <translation>OpenPBR- und glTF-PBR-Oberflächen als .mtlx</translation>
  </message>
  <message>
   <source>A preview sphere with the material as .glb, for the web and engines</source>
   <translation>Eine Vorschaukugel mit dem Material als .glb, für das Web und Engines</translation>
  </message>
  <message>
   <source>A preview sphere with UsdPreviewSurface as .usdz, for pipelines and Quick Look</source>
   <translation>Eine Vorschaukugel mit UsdPreviewSurface als .usdz, für Pipelines und Quick Look</translation>
  </message>
  <message>
   <source>Shaders</source>
   <translation>Shader</translation>
  </message>
  <message>
   <source>A page with a light to drag, for any browser and for strict sites</source>
   <translation>Eine Seite mit beweglichem Licht, für jeden Browser und für strenge Websites</translation>
  </message>
  <message>
   <source>.ptm, .rti and a tree for web viewers, for conservators</source>
   <translation>.ptm, .rti und ein Baum für Web-Betrachter, für Restauratoren</translation>
  </message>
  <message>
   <source>BRDF tables</source>
   <translation>BRDF-Tabellen</translation>
  </message>
  <message>
   <source>CSV, ALTA, MERL, RGL, and the nearest model as MaterialX</source>
   <translation>CSV, ALTA, MERL, RGL und das nächste Modell als MaterialX</translation>
  </message>
  <message>
   <source>no height: the slopes of the surface were not observed</source>
   <translation>keine Höhe: die Steigungen der Oberfläche waren nicht sichtbar</translation>
  </message>
  <message>
   <source>no ambient occlusion: the relief of the surface was not observed</source>
   <translation>keine Umgebungsverdeckung: das Relief der Oberfläche war nicht sichtbar</translation>
  </message>
  <message>
   <source>no cavity: the material has no power law</source>
   <translation>keine Vertiefungskarte: das Material hat kein Potenzgesetz</translation>
  </message>
  <message>
   <source>no height: the material came without one</source>
   <translation>keine Höhe: das Material kam ohne</translation>
  </message>
  <message>
   <source>no ambient occlusion: the material came without it</source>
   <translation>keine Umgebungsverdeckung: das Material kam ohne</translation>
  </message>
  <message>
   <source>no cavity: the material came without one</source>
   <translation>keine Vertiefungskarte: das Material kam ohne</translation>
  </message>
  <message>
   <source>no height: it is measured on photographs of these texels, and none were given</source>
   <translation>keine Höhe: sie wird an Fotos dieser Texel gemessen, und es gibt keine</translation>
  </message>
  <message>
   <source>no ambient occlusion: it is measured on photographs of these texels, and none were given</source>
   <translation>keine Umgebungsverdeckung: sie wird an Fotos dieser Texel gemessen, und es gibt keine</translation>
  </message>
  <message>
   <source>ambient occlusion</source>
   <translation>Umgebungsverdeckung</translation>
  </message>
  <message>
   <source>f0 of a full specular level</source>
   <translation>F0 bei vollem Spiegelpegel</translation>
  </message>
  <message>
   <source>choosing textures</source>
   <translation>Texturen werden gewählt</translation>
  </message>
  <message>
   <source>base colours are in %1, as their chromaticities say: choose %2 for this image in the program</source>
   <translation>Grundfarben sind in %1, wie ihre Farbarten sagen: für dieses Bild im Programm %2 wählen</translation>
  </message>
  <message>
   <source>these textures hold no f0, and importers take 0.04</source>
   <translation>diese Texturen enthalten kein F0, und Importe nehmen 0,04</translation>
  </message>
  <message>
   <source>f0 is up to %1, of which a specular level says 0.08</source>
   <translation>F0 reicht bis %1, wovon ein Spiegelpegel 0,08 angibt</translation>
  </message>
  <message>
   <source>unknown preset %1; choose from %2</source>
   <translation>unbekannte Voreinstellung %1; möglich: %2</translation>
  </message>
  <message>
   <source>normals are flat: lamps on one arc do not show the side that a slope faces</source>
   <translation>Normalen sind flach: Lampen auf einem Bogen zeigen nicht, wohin eine Steigung weist</translation>
  </message>
  <message>
   <source>normals are flat: they are measured on photographs of these texels, and none were given</source>
   <translation>Normalen sind flach: sie werden an Fotos dieser Texel gemessen, und es gibt keine</translation>
  </message>
  <message>
   <source>normals tilt along the arc of the lamps alone</source>
   <translation>Normalen neigen sich nur längs des Bogens der Lampen</translation>
  </message>
  <message>
   <source>the height has %1 regions, and the steps between them are unknown</source>
   <translation>die Höhe hat %1 Bereiche, und die Stufen dazwischen sind unbekannt</translation>
  </message>
  <message>
   <source>up to a third darker where light between facets is not simulated, as in plain glTF</source>
   <translation>bis zu einem Drittel dunkler, wo Licht zwischen Facetten fehlt, wie in einfachem glTF</translation>
  </message>
  <message>
   <source>up to half brighter where light between facets is added, as three.js does</source>
   <translation>bis zur Hälfte heller, wo Licht zwischen Facetten hinzukommt, wie bei three.js</translation>
  </message>
  <message>
   <source>rough metal looks %1</source>
   <translation>raues Metall sieht %1 aus</translation>
  </message>
  <message>
   <source>texture coordinates are to be divided by %1</source>
   <translation>Texturkoordinaten sind durch %1 zu teilen</translation>
  </message>
  <message>
   <source>%1 × %2 UDIM tiles are one texture: %3</source>
   <translation>%1 × %2 UDIM-Kacheln sind eine Textur: %3</translation>
  </message>
  <message>
   <source>not written: %1</source>
   <translation>nicht geschrieben: %1</translation>
  </message>
  <message>
   <source>f0 varies, and %1 states its mean, %2</source>
   <translation>F0 variiert, und %1 nennt das Mittel, %2</translation>
  </message>
  <message>
   <source>the layer</source>
   <translation>die Schicht</translation>
  </message>
  <message>
   <source>UsdPreviewSurface has no %1; the layer of MaterialX has</source>
   <translation>UsdPreviewSurface hat kein %1; die Schicht von MaterialX hat es</translation>
  </message>
  <message>
   <source>the layer of MaterialX: %1</source>
   <translation>die Schicht von MaterialX: %1</translation>
  </message>
  <message>
   <source>writing the page</source>
   <translation>Seite wird geschrieben</translation>
  </message>
  <message>
   <source>the page holds %1 in 16 bits</source>
   <translation>die Seite enthält %1 in 16 Bit</translation>
  </message>
  <message>
   <source>the weights of its planes</source>
   <translation>die Gewichte ihrer Ebenen</translation>
  </message>
  <message>
   <source>its maps</source>
   <translation>ihre Karten</translation>
  </message>
  <message>
   <source>beyond %1 texels a side the page shows averages, and finer texels in tiles of 8 bits</source>
   <translation>ab %1 Texeln je Kante zeigt die Seite Mittelwerte, feinere Texel in Kacheln mit 8 Bit</translation>
  </message>
 </context>
 <context>
  <name>several</name>
  <message>
   <source>%1 points…</source>
   <translation>%1 Punkte…</translation>
  </message>
  <message>
   <source>%1 samples</source>
   <translation>%1 Abtastungen</translation>
  </message>
  <message>
   <source>%1 of %2 · %3 textures</source>
   <translation>%1 von %2 · %3 Texturen</translation>
  </message>
  <message>
   <source>RMS × cos is lowest with %1 terms</source>
   <translation>RMS × cos ist am kleinsten mit %1 Termen</translation>
  </message>
  <message>
   <source>Held-out errors are best with %1 terms%2</source>
   <translation>Validierungsfehler sind am besten mit %1 Termen%2</translation>
  </message>
  <message>
   <source>Choose %1 terms of %2</source>
   <translation>%1 Terme von %2 wählen</translation>
  </message>
  <message>
   <source>%1, %2 terms</source>
   <translation>%1, %2 Terme</translation>
  </message>
  <message>
   <source>Export %1 targets</source>
   <translation>%1 Ziele exportieren</translation>
  </message>
  <message>
   <source>%1 settings measured so far.%2</source>
   <translation>%1 Einstellungen bisher gemessen.%2</translation>
  </message>
  <message>
   <source>%1 settings at %2 × %3</source>
   <translation>%1 Einstellungen bei %2 × %3</translation>
  </message>
  <message>
   <source>pays off after %1 frames against the reference</source>
   <translation>lohnt sich gegenüber der Referenz nach %1 Bildern</translation>
  </message>
  <message>
   <source>%1 projects</source>
   <translation>%1 Projekte</translation>
  </message>
  <message>
   <source>waiting for %1 to end</source>
   <translation>wartet auf %1</translation>
  </message>
  <message>
   <source>and %1 more: each</source>
   <translation>und %1 weitere: jedes</translation>
  </message>
 </context>
 <context>
  <name>engine</name>
  <message>
   <source>Sigma</source>
   <translation>Sigma</translation>
  </message>
  <message>
   <source>First lobe along the surface. </source>
   <translation>Erste Keule längs der Fläche. </translation>
  </message>
  <message>
   <source>First lobe along the normal. </source>
   <translation>Erste Keule längs der Normalen. </translation>
  </message>
  <message>
   <source>Second lobe along the surface. </source>
   <translation>Zweite Keule längs der Fläche. </translation>
  </message>
  <message>
   <source>Second lobe along the normal. </source>
   <translation>Zweite Keule längs der Normalen. </translation>
  </message>
  <message>
   <source>Third lobe along the surface. </source>
   <translation>Dritte Keule längs der Fläche. </translation>
  </message>
  <message>
   <source>Third lobe along the normal. </source>
   <translation>Dritte Keule längs der Normalen. </translation>
  </message>
  <message>
   <source>Alpha</source>
   <translation>Alpha</translation>
  </message>
  <message>
   <source>Alpha x</source>
   <translation>Alpha x</translation>
  </message>
  <message>
   <source>Alpha y</source>
   <translation>Alpha y</translation>
  </message>
  <message>
   <source>Base weight</source>
   <translation>Grundgewicht</translation>
  </message>
  <message>
   <source>Base diffuse roughness</source>
   <translation>Diffuse Rauheit</translation>
  </message>
  <message>
   <source>Base metalness</source>
   <translation>Metallanteil</translation>
  </message>
  <message>
   <source>Specular weight</source>
   <translation>Spiegelgewicht</translation>
  </message>
  <message>
   <source>Specular colour</source>
   <translation>Spiegelfarbe</translation>
  </message>
  <message>
   <source>Specular roughness</source>
   <translation>Spiegelrauheit</translation>
  </message>
  <message>
   <source>Specular ior</source>
   <translation>Brechzahl</translation>
  </message>
  <message>
   <source>Coat weight</source>
   <translation>Lackgewicht</translation>
  </message>
  <message>
   <source>Coat colour</source>
   <translation>Lackfarbe</translation>
  </message>
  <message>
   <source>Coat roughness</source>
   <translation>Lackrauheit</translation>
  </message>
  <message>
   <source>Coat ior</source>
   <translation>Lack-Brechzahl</translation>
  </message>
  <message>
   <source>Coat darkening</source>
   <translation>Lackdunklung</translation>
  </message>
  <message>
   <source>Fuzz weight</source>
   <translation>Flaumgewicht</translation>
  </message>
  <message>
   <source>Fuzz colour</source>
   <translation>Flaumfarbe</translation>
  </message>
  <message>
   <source>Fuzz roughness</source>
   <translation>Flaumrauheit</translation>
  </message>
  <message>
   <source>Thin film weight</source>
   <translation>Filmanteil</translation>
  </message>
  <message>
   <source>Thin film thickness</source>
   <translation>Filmdicke</translation>
  </message>
  <message>
   <source>Thin film ior</source>
   <translation>Film-Brechzahl</translation>
  </message>
  <message>
   <source>Specular roughness anisotropy</source>
   <translation>Anisotropie</translation>
  </message>
  <message>
   <source>Coat roughness anisotropy</source>
   <translation>Lack-Anisotropie</translation>
  </message>
  <message>
   <source>Spacing</source>
   <translation>Abstand</translation>
  </message>
  <message>
   <source>Floor</source>
   <translation>Boden</translation>
  </message>
  <message>
   <source>Blender: a script and, where Blender is at hand, a .blend</source>
   <translation>Blender: ein Skript und, wo Blender vorhanden ist, ein .blend</translation>
  </message>
  <message>
   <source>Parametrisation</source>
   <translation>Parametrisierung</translation>
  </message>
  <message>
   <source>Weighting</source>
   <translation>Gewichtung</translation>
  </message>
  <message>
   <source>Side</source>
   <translation>Kante</translation>
  </message>
  <message>
   <source>Products</source>
   <translation>Produkte</translation>
  </message>
  <message>
   <source>Max theta</source>
   <translation>Max. Theta</translation>
  </message>
  <message>
   <source>Epsilon</source>
   <translation>Epsilon</translation>
  </message>
  <message>
   <source>Metric</source>
   <translation>Maß</translation>
  </message>
  <message>
   <source>Theta</source>
   <translation>Theta</translation>
  </message>
  <message>
   <source>Phi</source>
   <translation>Phi</translation>
  </message>
  <message>
   <source>Facing theta</source>
   <translation>Theta (Ziel)</translation>
  </message>
  <message>
   <source>Facing phi</source>
   <translation>Phi (Ziel)</translation>
  </message>
  <message>
   <source>Light theta</source>
   <translation>Elevation</translation>
  </message>
  <message>
   <source>Light phi</source>
   <translation>Azimut</translation>
  </message>
  <message>
   <source>Environment rotation</source>
   <translation>Drehung</translation>
  </message>
  <message>
   <source>Noise</source>
   <translation>Rauschen</translation>
  </message>
  <message>
   <source>Turn</source>
   <translation>Drehung</translation>
  </message>
  <message>
   <source>Order</source>
   <translation>Ordnung</translation>
  </message>
  <message>
   <source>Cube</source>
   <translation>Würfel</translation>
  </message>
  <message>
   <source>Fine</source>
   <translation>Fein</translation>
  </message>
  <message>
   <source>Near points</source>
   <translation>Nahe Punkte</translation>
  </message>
  <message>
   <source>Coefficients</source>
   <translation>Koeffizienten</translation>
  </message>
  <message>
   <source>Occluder cells</source>
   <translation>Zellen</translation>
  </message>
  <message>
   <source>Signs</source>
   <translation>Vorzeichen</translation>
  </message>
  <message>
   <source>Views</source>
   <translation>Ansichten</translation>
  </message>
  <message>
   <source>Weights</source>
   <translation>Gewichte</translation>
  </message>
  <message>
   <source>Compress</source>
   <translation>Komprimieren</translation>
  </message>
  <message>
   <source>widths</source>
   <translation>Bildbreiten</translation>
  </message>
  <message>
   <source>ACES</source>
   <translation>ACES</translation>
  </message>
  <message>
   <source>Average</source>
   <translation>Mittelwert</translation>
  </message>
  <message>
   <source>BRDF</source>
   <translation>BRDF</translation>
  </message>
  <message>
   <source>Crash reports</source>
   <translation>Absturzberichte</translation>
  </message>
  <message>
   <source>Edit</source>
   <translation>Bearbeiten</translation>
  </message>
  <message>
   <source>File</source>
   <translation>Datei</translation>
  </message>
  <message>
   <source>Help</source>
   <translation>Hilfe</translation>
  </message>
  <message>
   <source>FLIP</source>
   <translation>FLIP</translation>
  </message>
  <message>
   <source>Float</source>
   <translation>Abdocken</translation>
  </message>
  <message>
   <source>MaterialX</source>
   <translation>MaterialX</translation>
  </message>
  <message>
   <source>Opacity</source>
   <translation>Deckkraft</translation>
  </message>
  <message>
   <source>OpenEXR</source>
   <translation>OpenEXR</translation>
  </message>
  <message>
   <source>OpenPBR</source>
   <translation>OpenPBR</translation>
  </message>
  <message>
   <source>glTF</source>
   <translation>glTF</translation>
  </message>
  <message>
   <source>sRGB</source>
   <translation>sRGB</translation>
  </message>
  <message>
   <source>Primer</source>
   <translation>Primer</translation>
  </message>
  <message>
   <source>Peak</source>
   <translation>Spitze</translation>
  </message>
  <message>
   <source>Save image</source>
   <translation>Bild speichern</translation>
  </message>
  <message>
   <source>Save turntable</source>
   <translation>Drehung speichern</translation>
  </message>
  <message>
   <source>Save the plots as SVG and CSV</source>
   <translation>Diagramme als SVG und CSV speichern</translation>
  </message>
  <message>
   <source>slice 0 is black by definition; the darkest photograph has a mean radiance of %1, %2 slices between them are darkened copies of it</source>
   <translation>Schicht 0 ist definitionsgemäß schwarz; das dunkelste Foto hat eine mittlere Strahldichte von %1, %2 Schichten dazwischen sind abgedunkelte Kopien davon</translation>
  </message>
  <message>
   <source>assumed</source>
   <translation>angenommen</translation>
  </message>
  <message>
   <source>exact</source>
   <translation>genau</translation>
  </message>
  <message>
   <source>good</source>
   <translation>gut</translation>
  </message>
  <message>
   <source>note</source>
   <translation>Hinweis</translation>
  </message>
  <message>
   <source>warning</source>
   <translation>Warnung</translation>
  </message>
  <message>
   <source>bad</source>
   <translation>schlecht</translation>
  </message>
  <message>
   <source>problem</source>
   <translation>Problem</translation>
  </message>
  <message>
   <source>auto</source>
   <translation>automatisch</translation>
  </message>
  <message>
   <source>Closes the dock widget</source>
   <translation>Schließt den Bereich</translation>
  </message>
  <message>
   <source>Undocks and re-attaches the dock widget</source>
   <translation>Löst den Bereich und dockt ihn wieder an</translation>
  </message>
  <message>
   <source>Scroll Left</source>
   <translation>Nach links</translation>
  </message>
  <message>
   <source>Scroll Right</source>
   <translation>Nach rechts</translation>
  </message>
  <message>
   <source>One-lobe Lafortune fits of the 100 MERL materials</source>
   <translation>Anpassungen der 100 MERL-Materialien mit einer Lafortune-Keule</translation>
  </message>
  <message>
   <source>Three-lobe Lafortune fits of measured materials, published by S. Westin, Cornell Program of Computer Graphics</source>
   <translation>Anpassungen gemessener Materialien mit drei Lafortune-Keulen, veröffentlicht von S. Westin, Cornell Program of Computer Graphics</translation>
  </message>
  <message>
   <source>%1 left</source>
   <translation>noch %1</translation>
  </message>
  <message>
   <source>Power</source>
   <translation>Leistung</translation>
  </message>
  <message>
   <source>Today %1</source>
   <translation>Heute %1</translation>
  </message>
  <message>
   <source>Yesterday %1</source>
   <translation>Gestern %1</translation>
  </message>
  <message>
   <source>uses %1, which is not read</source>
   <translation>verwendet %1, was nicht gelesen wird</translation>
  </message>
  <message>
   <source>is neither a built-in model nor a file</source>
   <translation>ist weder ein eingebautes Modell noch eine Datei</translation>
  </message>
  <message>
   <source>is neither a file nor a built-in environment</source>
   <translation>ist weder eine Datei noch eine eingebaute Umgebung</translation>
  </message>
  <message>
   <source>Permission denied</source>
   <translation>Zugriff verweigert</translation>
  </message>
  <message>
   <source>No such file or directory</source>
   <translation>Datei oder Ordner existiert nicht</translation>
  </message>
  <message>
   <source>No space left on device</source>
   <translation>kein Platz mehr auf dem Datenträger</translation>
  </message>
  <message>
   <source>Input/output error</source>
   <translation>Ein-/Ausgabefehler</translation>
  </message>
  <message>
   <source>Read-only file system</source>
   <translation>Dateisystem ist schreibgeschützt</translation>
  </message>
  <message>
   <source>Is a directory</source>
   <translation>es ist ein Ordner</translation>
  </message>
  <message>
   <source>Not a directory</source>
   <translation>es ist kein Ordner</translation>
  </message>
  <message>
   <source>File exists</source>
   <translation>Datei existiert</translation>
  </message>
  <message>
   <source>Too many open files</source>
   <translation>zu viele offene Dateien</translation>
  </message>
  <message>
   <source>File name too long</source>
   <translation>Dateiname zu lang</translation>
  </message>
  <message>
   <source>Operation not permitted</source>
   <translation>Vorgang nicht erlaubt</translation>
  </message>
  <message>
   <source>Disk quota exceeded</source>
   <translation>Kontingent auf dem Datenträger aufgebraucht</translation>
  </message>
  <message>
   <source>Device or resource busy</source>
   <translation>Gerät oder Ressource belegt</translation>
  </message>
  <message>
   <source>Connection refused</source>
   <translation>Verbindung verweigert</translation>
  </message>
  <message>
   <source>Cannot allocate memory</source>
   <translation>Speicher ließ sich nicht belegen</translation>
  </message>
  <message>
   <source>line %1 </source>
   <translation>Zeile %1 </translation>
  </message>
  <message>
   <source>line %1</source>
   <translation>Zeile %1</translation>
  </message>
  <message>
   <source>%1 × none</source>
   <translation>%1 × keines</translation>
  </message>
  <message>
   <source>directions %1</source>
   <translation>Richtungen %1</translation>
  </message>
  <message>
   <source>samples %1</source>
   <translation>Abtastungen %1</translation>
  </message>
  <message>
   <source>needed</source>
   <translation>nötig</translation>
  </message>
  <message>
   <source>skipped</source>
   <translation>ausgelassen</translation>
  </message>
 </context>
</TS>
